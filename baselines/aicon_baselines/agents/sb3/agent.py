"""A saved agent as a policy."""

import hashlib
from pathlib import Path
from typing import Any, cast

import numpy as np
import torch
from numpy.typing import NDArray

from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.agents.sb3.files import load_algorithm, load_statistics, read_settings, weights
from aicon_baselines.agents.sb3.from_pusher import OFFSETS, to_target, with_offsets
from aicon_baselines.agents.sb3.last_action import LAST_ACTION
from aicon_baselines.agents.sb3.settings import training_command

Observation = dict[str, NDArray[Any]]


class Agent:
    """A saved agent with the `predict` of a policy, which expects and gives what the environment does.

    Readings are stacked and normalised as in training. One that is missing (NaN) keeps its last value. Its `state` is
    the stacks (those of readings as they were seen, that of the last action as it will be seen next) and the state of
    the random numbers.

    Args:
        folder: Folder of the agent; an error says what is missing there, or that it is for another task.
        task: Name of the task.
        sampled: Whether actions are drawn as in training also where `predict` is asked for the most likely ones.
    """

    def __init__(self, folder: Path, task: str, sampled: bool = False) -> None:
        self._folder, self._sampled = folder, sampled
        self.settings, self._shapes = read_settings(folder)
        if self.settings.task != task:
            raise ComparisonError(
                f"the agent in {folder} was trained for {self.settings.task!r}, not {task!r}. Compare it with --task "
                f"{self.settings.task}, or train another: {training_command(task, self.settings.algorithm)}"
            )
        self._model = load_algorithm(folder, self.settings)
        self._statistics = load_statistics(folder) if self.settings.normalized else None

    @property
    def name(self) -> str:
        """Algorithm, steps and the beginning of a hash, so that rows of two agents never get the same name."""
        digest = hashlib.sha256(b"".join(file.read_bytes() for file in weights(self._folder, self.settings)))
        mode = "_sampled" if self._sampled else ""
        return f"{self.settings.algorithm}_{self.settings.steps}_{digest.hexdigest()[:4]}{mode}"

    def predict(
        self,
        observation: Observation,
        state: Any = None,
        episode_start: NDArray[np.bool_] | None = None,
        deterministic: bool = True,
    ) -> tuple[NDArray[np.float32], Any]:
        """Choose the next actions (B, m); see `aicon_baselines.Predictor`."""
        sensed = self._select(observation)
        count = len(next(iter(sensed.values())))
        start = np.ones(count, np.bool_) if state is None or episode_start is None else episode_start
        stacks, noise = state or (self._empty(count), torch.Generator().manual_seed(0).get_state())
        seen = {name: np.where(start[:, None], 0.0, stack) for name, stack in stacks.items()}
        sensed = {name: _fill(reading, seen[name]) for name, reading in sensed.items()}
        if OFFSETS in seen:
            sensed = with_offsets(sensed)
        seen |= {name: _push(reading, seen[name]) for name, reading in sensed.items()}
        with torch.random.fork_rng(devices=()):  # torch draws actions from its global numbers only
            torch.set_rng_state(noise)
            action, _ = self._model.predict(self._normalize(seen), deterministic=deterministic and not self._sampled)
            noise = torch.get_rng_state()
        if LAST_ACTION in seen:
            seen[LAST_ACTION] = _push(action, seen[LAST_ACTION])
        reach = self.settings.reach
        return action if reach is None else to_target(action, sensed, reach), (seen, noise)

    def _select(self, observation: Observation) -> Observation:
        """Take the readings that the agent knows; others, such as the goal, it does not see."""
        sensed = {name: shape for name, shape in self._shapes.items() if name not in (LAST_ACTION, OFFSETS)}
        for name, shape in sensed.items():
            if name not in observation or observation[name].shape[1:] != shape:
                offered = {key: value.shape[1:] for key, value in observation.items()}
                raise ComparisonError(
                    f"the agent in {self._folder} observes {sensed}, and this condition offers {offered}: choose "
                    "conditions with the readings that it was trained with"
                )
        return {name: observation[name] for name in sensed}

    def _empty(self, count: int) -> Observation:
        sizes = {name: int(np.prod(shape)) * self.settings.stack for name, shape in self._shapes.items()}
        return {name: np.zeros((count, size)) for name, size in sizes.items()}

    def _normalize(self, seen: Observation) -> Observation:
        return cast("Observation", self._statistics.normalize_obs(seen)) if self._statistics else seen


def _fill(reading: NDArray[Any], stack: NDArray[Any]) -> NDArray[Any]:
    """Put the last reading, 0 at the start of an episode, where a number is missing; (B, n)."""
    return np.where(np.isnan(reading), stack[:, -reading.shape[1] :], reading)


def _push(reading: NDArray[Any], stack: NDArray[Any]) -> NDArray[Any]:
    """Append a reading (B, n) to a stack (B, k n) and drop the oldest, as `VecFrameStack` does."""
    return np.concatenate([stack[:, reading.shape[1] :], reading], axis=-1)
