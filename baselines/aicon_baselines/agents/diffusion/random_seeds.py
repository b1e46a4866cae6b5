"""Random numbers that depend on the episode alone, and not on what else is in the batch."""

import hashlib

import numpy as np
import torch
from numpy.typing import NDArray


def episode_seed(seed: int, first_readings: list[NDArray[np.generic]]) -> int:
    """Return the seed of an episode, below 2⁶².

    Args:
        seed: Seed of the policy.
        first_readings: The first observation of the episode.
    """
    digest = hashlib.sha256()
    for reading in first_readings:
        digest.update(np.ascontiguousarray(reading).tobytes())

    sequence = np.random.SeedSequence([seed, *digest.digest()])
    return _draw_word(sequence) >> 2


def sample_generator(episode: int, sample: int) -> torch.Generator:
    """Return the random numbers of one sample of actions.

    Args:
        episode: Seed of the episode.
        sample: How often the episode has sampled before.
    """
    # Not the sum: the seeds of two episodes may be near each other.
    sequence = np.random.SeedSequence([episode, sample])
    return torch.Generator().manual_seed(_draw_word(sequence) % 2**63)


def _draw_word(sequence: np.random.SeedSequence) -> int:
    return int(sequence.generate_state(1, np.uint64)[0])
