"""A saved agent as a policy."""

import hashlib
from pathlib import Path
from typing import Any, cast

import numpy as np
import torch
from numpy.typing import NDArray

from aicon_baselines.agents.sb3.agent_folder import load_agent, read_config, weight_files
from aicon_baselines.agents.sb3.training_config import training_command
from aicon_baselines.agents.sb3.wrappers import LAST_ACTION, OFFSETS, add_offsets, target_of_action
from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.evaluation.predictor import starting_rows

Observation = dict[str, NDArray[Any]]

_DERIVED = (LAST_ACTION, OFFSETS)  # no readings of the environment


class Agent:
    """A saved agent with the `predict` of a policy, which expects and gives what the task does.

    Readings are stacked and normalised as in training. One that is missing, or infinite, keeps its
    last value. Its `state` is the stacks (those of readings as they were seen, that of the last
    action as it will be seen next) and the state of the random numbers.

    Args:
        folder: Folder of the agent.
        task: Name of the task.
        sampled: Whether actions are drawn as in training also where `predict` is asked for the
            most likely ones.
        trust: Whether code that its files may hold is allowed to run; see `agent_folder`.

    Raises:
        ComparisonError: Where something is missing in the folder, the agent is for another task, or
            it holds code and is not trusted.
    """

    def __init__(self, folder: Path, task: str, sampled: bool = False, trust: bool = False) -> None:
        self._folder = folder
        self._sampled = sampled

        self.config, self._shapes = read_config(folder)
        if self.config.task != task:
            raise ComparisonError(
                f"the agent in {folder} was trained for {self.config.task!r}, not {task!r}. "
                f"Compare it with --task {self.config.task}, or train another: "
                f"{training_command(task, self.config.algorithm)}"
            )

        self._model, self._statistics = load_agent(folder, self.config, trust)

    @property
    def name(self) -> str:
        """Algorithm, steps and the beginning of a hash, so that no two agents share a name."""
        digest = hashlib.sha256()
        for file in weight_files(self._folder, self.config):
            digest.update(file.read_bytes())

        name = f"{self.config.algorithm}_{self.config.steps}_{digest.hexdigest()[:4]}"
        return f"{name}_sampled" if self._sampled else name

    def predict(
        self,
        observation: Observation,
        state: Any = None,
        episode_start: NDArray[np.bool_] | None = None,
        deterministic: bool = True,
    ) -> tuple[NDArray[np.float32], Any]:
        """Choose the next actions (B, m); see `aicon_baselines.evaluation.Predictor`."""
        readings = self._select(observation)
        count = len(next(iter(readings.values())))

        # 1. Recall the stacks, which are empty where an episode begins.
        stacks, random_state = self._initial_state(count) if state is None else state
        starts = starting_rows(count, state, episode_start)
        stacks = {name: np.where(starts[:, None], 0.0, stack) for name, stack in stacks.items()}

        # 2. Append the readings, as the environments of the training do.
        for name, reading in readings.items():
            readings[name] = _fill_missing(reading, stacks[name])
        if OFFSETS in stacks:
            readings = add_offsets(readings)
        for name, reading in readings.items():
            stacks[name] = _append(reading, stacks[name])

        # 3. Ask the network.
        deterministic = deterministic and not self._sampled
        action, random_state = self._act(stacks, random_state, deterministic)

        # 4. Remember the action, and give it in the units of the environment.
        if LAST_ACTION in stacks:
            stacks[LAST_ACTION] = _append(action, stacks[LAST_ACTION])
        if self.config.reach is not None:
            action = target_of_action(action, readings, self.config.reach)
        return action, (stacks, random_state)

    def _select(self, observation: Observation) -> Observation:
        """Take the readings that the agent knows; others, such as the goal, it does not see."""
        expected = {name: shape for name, shape in self._shapes.items() if name not in _DERIVED}

        # Other objects have other numbers of keypoints.
        for name, shape in expected.items():
            if name not in observation or observation[name].shape[1:] != shape:
                offered = {key: value.shape[1:] for key, value in observation.items()}
                raise ComparisonError(
                    f"the agent in {self._folder} observes {expected}, and this condition offers "
                    f"{offered}: choose conditions with the readings that it was trained with"
                )

        return {name: observation[name] for name in expected}

    def _initial_state(self, count: int) -> tuple[Observation, torch.Tensor]:
        """Return empty stacks (B, k n), and the state of random numbers that all runs share."""
        stacks: Observation = {}
        for name, shape in self._shapes.items():
            size = int(np.prod(shape)) * self.config.stack
            stacks[name] = np.zeros((count, size))

        return stacks, torch.Generator().manual_seed(0).get_state()

    def _act(
        self, stacks: Observation, random_state: torch.Tensor, deterministic: bool
    ) -> tuple[NDArray[Any], torch.Tensor]:
        """Return the network's actions (B, m), and the state of the random numbers afterwards."""
        inputs = stacks
        if self._statistics is not None:
            inputs = cast("Observation", self._statistics.normalize_obs(stacks))

        # Torch draws actions from its global random numbers, which are others' as well.
        with torch.random.fork_rng(devices=()):
            torch.set_rng_state(random_state)
            action, _ = self._model.predict(inputs, deterministic=deterministic)
            return action, torch.get_rng_state()


def _fill_missing(reading: NDArray[Any], stack: NDArray[Any]) -> NDArray[Any]:
    """Replace what is not finite of a reading (B, n) by the last value, 0 at the start."""
    last_reading = stack[:, -reading.shape[1] :]
    return np.where(np.isfinite(reading), reading, last_reading)


def _append(reading: NDArray[Any], stack: NDArray[Any]) -> NDArray[Any]:
    """Append a reading (B, n) to a stack (B, k n) and drop the oldest, as `VecFrameStack` does."""
    without_oldest = stack[:, reading.shape[1] :]
    return np.concatenate([without_oldest, reading], axis=-1)
