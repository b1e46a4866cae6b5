"""A saved diffusion policy of LeRobot in our comparison."""

import hashlib
from math import prod
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from aicon_baselines.agents.diffusion.checkpoint import CONFIG, WEIGHTS, load
from aicon_baselines.agents.diffusion.hub import locate
from aicon_baselines.agents.diffusion.lerobot_names import (
    ACTION,
    KEYPOINTS,
    PIXELS,
    STATE,
    import_lerobot,
)
from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.evaluation.predictor import starting_rows
from aicon_baselines.tasks.registry import lesson_of

Observation = dict[str, NDArray[Any]]
Memory = dict[str, Tensor]

_READINGS = {STATE: "agent_pos", KEYPOINTS: "environment_state", PIXELS: "pixels"}
"""What LeRobot calls features in the observations of an environment."""


class Agent:
    """A saved diffusion policy in a task that has a lesson.

    It observes the last `n_obs_steps` observations, samples `horizon` actions and executes
    `n_action_steps` of them before it looks again. In pushT it is told nothing of the goal: what it
    pushes to is where its demonstrations ended.

    Rows of a batch are separate robots, each with its own history, queue of actions and random
    numbers. These are drawn from a seed, the first observation of the episode and the number of
    samples since: an episode goes the same way in every batch and every run, up to the last bits of
    a batched computation.

    The memory holds, for B robots with histories of o observations and queues of a actions:

    | key | shape | content |
    |---|---|---|
    | `observation.*` | (B, o, ...) | normalised observations, the newest last |
    | `action` | (B, a, n) | the actions sampled last |
    | `executed` | (B,) | how many of them were executed |
    | `samples` | (B,) | how often the episode has sampled |
    | `episode_seed` | (B,) | seed of the episode |

    Args:
        source: Folder of a policy, or the name of a repository of the Hugging Face hub.
        sampler: "DDPM" or "DDIM"; by default the checkpoint's.
        inference_steps: Number of denoising steps; by default the checkpoint's.
        seed: Seed of the sampler.
        task: Name of the task.

    Raises:
        ComparisonError: Where the policy cannot be found, loaded, or used in the task.
    """

    def __init__(
        self,
        source: str | Path,
        sampler: str | None = None,
        inference_steps: int | None = None,
        seed: int = 0,
        task: str = "pusht",
    ) -> None:
        self._seed, self._lesson = seed, lesson_of(task)
        self._folder = locate(str(source))

        self._checkpoint = load(self._folder, sampler, inference_steps)
        self._config: Any = self._checkpoint.policy.config
        self._check_features()
        self._to_tensors = import_lerobot("envs.utils").preprocess_observation

    @property
    def name(self) -> str:
        """Observation, sampler and the beginning of a hash, so that no two policies share it."""
        observed = "pixels" if PIXELS in self._config.input_features else "state"
        sampler = self._config.noise_scheduler_type.lower()
        steps = self._checkpoint.policy.diffusion.num_inference_steps
        digest = hashlib.sha256((self._folder / WEIGHTS).read_bytes()).hexdigest()

        return f"diffusion_{observed}_{sampler}{steps}_{digest[:4]}"

    @property
    def env_options(self) -> dict[str, Any]:
        """What the environment has to be built with, for a policy that sees pictures."""
        if PIXELS not in self._config.input_features:
            return {}

        # Pictures of the size that it was trained with.
        _, height, width = self._config.input_features[PIXELS].shape
        return {
            "obs_type": "pixels_agent_pos",
            "observation_height": height,
            "observation_width": width,
        }

    @torch.no_grad()
    def predict(
        self,
        observation: Observation,
        state: Any = None,
        episode_start: NDArray[np.bool_] | None = None,
        deterministic: bool = True,
    ) -> tuple[Any, Any]:
        """Choose the next actions (B, n); see `aicon_baselines.evaluation.Predictor`.

        Args:
            observation: One array (B, ...) per reading.
            state: The memory; see the class.
            episode_start: (B,), true where an episode begins.
            deterministic: Whether the random numbers depend on the episode alone; else they are
                others in every run.

        Returns:
            The actions, and the memory for the next call.
        """
        readings = self._select(observation)
        count = len(next(iter(readings.values())))
        previous: Memory = self._empty_memory(count) if state is None else state
        starts = torch.from_numpy(starting_rows(count, state, episode_start))

        # 1. Append what is seen to the histories.
        seen = self._checkpoint.preprocess(self._to_tensors(readings))
        memory = dict(previous)
        for name in self._config.input_features:
            memory[name] = _append(previous[name], seen[name], starts)

        # 2. Where an episode begins, forget the actions and draw a seed.
        repeats = self._repeats(previous, memory)
        memory["executed"] = previous["executed"].masked_fill(repeats, 0)
        self._begin_episodes(memory, starts & ~repeats, readings, deterministic)

        # 3. Sample actions where all have been executed.
        self._refill(memory)

        # 4. Execute the next one.
        action = memory[ACTION][torch.arange(count), memory["executed"]]
        memory["executed"] = memory["executed"] + 1
        return self._lesson.parted(action.numpy()), memory

    def _check_features(self) -> None:
        """Reject a policy that sees or does something else than the task offers."""
        inputs = {name: feature.shape for name, feature in self._config.input_features.items()}
        outputs = {name: feature.shape for name, feature in self._config.output_features.items()}
        parts = self._lesson.done

        if not set(inputs) <= set(self._lesson.seen) or outputs != {ACTION: (self._size,)}:
            raise ComparisonError(
                f"{self._folder / CONFIG} takes {inputs} and gives {outputs}; the task offers "
                f"{', '.join(self._lesson.seen)}, and takes {parts}"
            )

    def _select(self, observation: Observation) -> Observation:
        """Take the readings that the policy knows; others, such as the goal, it does not see."""
        readings = {}
        for feature_name, feature in self._config.input_features.items():
            names = self._lesson.seen[feature_name]
            told = " and ".join(names)

            # A policy takes pictures with channels first, an environment gives them last.
            expected = tuple(feature.shape)
            if feature_name == PIXELS:
                channels, height, width = feature.shape
                expected = (height, width, channels)

            offered = {key: value.shape[1:] for key, value in observation.items()}
            sizes = [prod(offered.get(name, ())) for name in names]
            if not set(names) <= set(offered) or sum(sizes) != prod(expected):
                raise ComparisonError(
                    f"the policy in {self._folder} observes {told} {expected}, and this condition "
                    f"offers {offered}: choose conditions with the readings that it was trained "
                    "with"
                )

            # A copy has no negative strides, which torch does not take.
            seen = self._lesson.feature(feature_name, observation)
            if not np.isfinite(seen).all():
                raise ComparisonError(
                    f"{told} has missing values, or infinite ones, of which a diffusion policy "
                    "knows nothing: choose other conditions"
                )
            readings[_READINGS[feature_name]] = seen

        return readings

    @property
    def _size(self) -> int:
        """How many numbers an action is, n."""
        return sum(self._lesson.done.values())

    def _empty_memory(self, count: int) -> Memory:
        """Return the memory of B robots that have seen nothing."""
        memory: Memory = {}
        for name, feature in self._config.input_features.items():
            memory[name] = torch.zeros(count, self._config.n_obs_steps, *feature.shape)

        memory[ACTION] = torch.zeros(count, self._config.n_action_steps, self._size)
        for name in ("executed", "samples", "episode_seed"):
            memory[name] = torch.zeros(count, dtype=torch.int64)
        return memory

    def _repeats(self, previous: Memory, memory: Memory) -> Tensor:
        """Return where an episode had just begun and begins again from the same observation, (B,).

        It would sample the same again, so it keeps what it sampled. That is no rare case: in a
        comparison, episodes that have ended stay in the batch like this.
        """
        repeats = (previous["samples"] == 1) & (previous["executed"] == 1)
        for name in self._config.input_features:
            unchanged = (previous[name] == memory[name]).flatten(1).all(dim=1)
            repeats = repeats & unchanged

        return repeats

    def _begin_episodes(
        self, memory: Memory, starts: Tensor, readings: Observation, deterministic: bool
    ) -> None:
        """Empty the queues of actions and draw a seed where an episode begins, (B,)."""
        memory["executed"] = memory["executed"].masked_fill(starts, self._config.n_action_steps)
        memory["samples"] = memory["samples"].masked_fill(starts, 0)

        memory["episode_seed"] = memory["episode_seed"].clone()
        for row in starts.nonzero().flatten().tolist():
            if deterministic:
                first_readings = [reading[row] for reading in readings.values()]
                memory["episode_seed"][row] = episode_seed(self._seed, first_readings)
            else:
                memory["episode_seed"][row] = torch.randint(2**62, ())

    def _refill(self, memory: Memory) -> None:
        """Sample actions where all have been executed."""
        rows = (memory["executed"] >= self._config.n_action_steps).nonzero().flatten()
        if len(rows) == 0:
            return

        generators = []
        for row in rows.tolist():
            episode, sample = int(memory["episode_seed"][row]), int(memory["samples"][row])
            generators.append(sample_generator(episode, sample))

        actions = self._sample(memory, rows, generators)
        memory[ACTION] = memory[ACTION].index_copy(0, rows, actions)
        memory["samples"] = memory["samples"].index_add(0, rows, torch.ones_like(rows))
        memory["executed"] = memory["executed"].index_fill(0, rows, 0)

    def _sample(self, memory: Memory, rows: Tensor, generators: list[torch.Generator]) -> Tensor:
        """Sample the next actions of these rows, (R, a, n), each with its random numbers."""
        config, network = self._config, self._checkpoint.policy.diffusion

        # 1. What has been observed.
        histories = {name: memory[name][rows] for name in config.input_features}
        if PIXELS in histories:
            histories["observation.images"] = histories.pop(PIXELS).unsqueeze(2)  # one camera
        condition = network._prepare_global_conditioning(histories)

        # 2. Noise becomes actions, step by step.
        noise = torch.stack(
            [torch.randn(config.horizon, self._size, generator=g) for g in generators]
        )
        actions = network.conditional_sample(
            len(rows), global_cond=condition, generator=generators, noise=noise
        )

        # 3. They begin with the oldest observation; take those from the newest one on.
        first = config.n_obs_steps - 1
        next_actions = actions[:, first : first + config.n_action_steps]
        targets: Tensor = self._checkpoint.postprocess(next_actions)
        return targets


def _append(history: Tensor, newest: Tensor, starts: Tensor) -> Tensor:
    """Append observations to histories; at a start the first one fills all, as in LeRobot.

    Args:
        history: (B, o, ...), the oldest first.
        newest: (B, ...).
        starts: (B,), true where an episode begins.
    """
    newest = newest[:, None]
    appended = torch.cat([history[:, 1:], newest], dim=1)

    starts = starts.view(-1, *[1] * (appended.ndim - 1))
    return torch.where(starts, newest.expand_as(appended), appended)


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
