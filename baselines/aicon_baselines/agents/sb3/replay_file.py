"""What SAC has seen, as a file of arrays: reading it runs no code."""

from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray
from stable_baselines3.common.buffers import DictReplayBuffer
from stable_baselines3.common.off_policy_algorithm import OffPolicyAlgorithm

from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.files import replacing

_ARRAYS = ("actions", "rewards", "dones", "timeouts")
_READINGS = ("observations", "next_observations")


def save_replay_buffer(path: Path, model: OffPolicyAlgorithm) -> None:
    """Write all steps that an algorithm remembers, the oldest first."""
    buffer = _buffer(model)
    oldest = buffer.pos if buffer.full else 0
    arrays: dict[str, Any] = {
        name: np.roll(array[: buffer.size()], -oldest, axis=0)
        for name, array in _arrays(buffer).items()
    }
    with replacing(path) as place, place.open("wb") as file:
        np.savez(file, **arrays)


def load_replay_buffer(path: Path, model: OffPolicyAlgorithm) -> None:
    """Let an algorithm remember saved steps, the latest if it has no room for all.

    Raises:
        ComparisonError: If the file does not hold what such an algorithm has seen.
    """
    buffer = _buffer(model)
    try:
        with np.load(path, allow_pickle=False) as saved:
            latest = {name: saved[name][-buffer.buffer_size :] for name in _arrays(buffer)}
        (count,) = {len(array) for array in latest.values()}  # as many of each
        for name, array in _arrays(buffer).items():
            array[:count] = latest[name]
    except (KeyError, ValueError, OSError, EOFError, BadZipFile) as error:
        raise ComparisonError(
            f"{path} does not hold what this agent has seen ({error}); without that file, the "
            "training goes on with an empty memory"
        ) from error

    buffer.pos = count % buffer.buffer_size
    buffer.full = count == buffer.buffer_size


def _buffer(model: OffPolicyAlgorithm) -> DictReplayBuffer:
    if not isinstance(model.replay_buffer, DictReplayBuffer):
        raise TypeError(f"expected a DictReplayBuffer, got {type(model.replay_buffer).__name__}")
    return model.replay_buffer


def _arrays(buffer: DictReplayBuffer) -> dict[str, NDArray[Any]]:
    """Return all arrays of a buffer, a row for each step, by name."""
    arrays = {name: getattr(buffer, name) for name in _ARRAYS}
    for kind in _READINGS:
        for name, array in getattr(buffer, kind).items():
            arrays[f"{kind}/{name}"] = array
    return arrays
