"""What happened in an episode: what the policy of one robot knew and decided, step by step."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import groupby, islice
from typing import Any, ClassVar, TypeVar

import gymnasium
import numpy as np
import torch
from gymnasium.vector import VectorEnv
from numpy.typing import NDArray
from torch import Tensor

from aicon_baselines.evaluation.episodes import run_episodes
from aicon_baselines.extras import naming_extra
from aicon_torch import Policy, StepTrace
from aicon_torch.inspection import QuantityTrace
from aicon_torch.quantities import AGE, PRESENT
from aicon_torch.resolution import Memory

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

Item = TypeVar("Item")
Kind = TypeVar("Kind", bound="Recording")


@dataclass(frozen=True)
class Recording:
    """An episode of one robot, with m memories at regular times.

    A task's own recording is derived from it, and adds what its pictures show.

    Attributes:
        policy: The policy.
        memories: What its steps returned, the first one first, each without a batch or of one row.
        success: Whether the episode succeeded; None where nobody knows.
        infos: What the environment told with what each of these steps saw, and in the end.
        pictures: What was seen meanwhile.
        env: The environment, which knows what the policy does not.
        seed: Seed of the episode.
        stride: Steps from one memory to the next.

    Example:
        >>> memories = []
        >>> action, memory = policy.predict(observation, memory)
        >>> memories.append(memory)
        >>> print(diagnose(Recording(policy, memories)))
    """

    resolved_at: ClassVar[str] = ""
    """The quantity at which the gradients that a figure shows are resolved."""

    policy: Policy
    memories: Sequence[Memory]
    success: bool | None = None
    infos: Sequence[dict[str, Any]] = ()
    pictures: Sequence[Any] = ()
    env: Any = None
    seed: int = 0
    stride: int = 1

    @property
    def time_step(self) -> float:
        """Time from one memory to the next, s."""
        return self.stride * self.policy.model.dt

    @property
    def steps(self) -> int:
        """Number of memories whose action was carried out, n ≤ m."""
        return len(self.memories)

    @property
    def ending(self) -> str:
        """How the episode ended, in two words at most."""
        return "arrival" if self.success else "time limit"

    @cached_property
    def times(self) -> FloatArray:
        """When each memory was computed, (m,), s."""
        return np.arange(len(self.memories), dtype=np.float64) * self.time_step

    @cached_property
    def memory(self) -> Memory:
        """All memories as one batch (m,).

        Raises:
            ValueError: If they are those of more than one robot.
        """
        actuator, declared = next(iter(self.policy.model.actuators.items()))
        first = self.memories[0]
        batch = {key: torch.stack([memory[key] for memory in self.memories]) for key in first}

        # One robot in a batch of its own.
        if batch[actuator].dim() == 3 and batch[actuator].shape[1] == 1:
            batch = {key: value.squeeze(1) for key, value in batch.items()}
        if batch[actuator].shape != (len(self.memories), declared.size):
            raise ValueError("memories: expected those of a single robot; take one row of each.")
        return batch

    @cached_property
    def log(self) -> tuple[Memory, Memory]:
        """Readings and actions by name, (m, n), as `policy.model.filter` takes them.

        A memory holds what was read last; where nothing new came there is no reading here, but NaN.
        """
        model, memory = self.policy.model, self.memory
        readings: Memory = {}
        for name, sensor in model.sensors.items():
            present = memory[name + PRESENT].unsqueeze(-1)
            readings[name] = torch.where(present, memory[name], torch.nan)
            if sensor.is_aged:
                readings[name + AGE] = memory[name + AGE]
        return readings, {name: memory[name] for name in model.actuators}

    @cached_property
    def trace(self) -> StepTrace:
        """What the policy knew and decided, with all memories as one batch (m,)."""
        return self.policy.trace(self.memory)

    @property
    def resolution(self) -> QuantityTrace:
        """What happened where the gradients were resolved."""
        return self.trace.quantities[self.resolved_at]

    @cached_property
    def exploring(self) -> BoolArray:
        """Whether it was exploring there, or anywhere if no place is named, (m,)."""
        quantities = self.trace.quantities
        places = [quantities[self.resolved_at]] if self.resolved_at else quantities.values()
        explored: BoolArray = np.logical_or.reduce(
            [quantity.exploring.numpy(force=True) for quantity in places]
        )
        return explored

    @cached_property
    def explorations(self) -> list[tuple[int, int]]:
        """First step of each exploration and the first one after it."""
        return true_intervals(self.exploring[: self.steps])

    def told(self, name: str) -> FloatArray:
        """What the environment told by this name, one row for each of `infos`."""
        return np.array([info[name] for info in self.infos], np.float64)


def record(
    kind: Callable[..., Kind],
    policy: Any,
    env: gymnasium.Env[Any, Any] | VectorEnv[Any, Any, Any],
    reset: dict[str, Any],
    horizon: int | None = None,
    *,
    stride: int = 1,
    look: Callable[[Any], Any] | None = None,
    beyond: bool = False,
) -> Kind:
    """Run an episode with a progress bar, on a terminal only, and keep what happened.

    Args:
        kind: What to make of it: a recording of the task.
        policy: The policy.
        env: Its environment, or a vector of one; it is closed in the end.
        reset: The arguments of its `reset`, a seed among them.
        horizon: Steps after which it ends; by default the environment's.
        stride: Steps from one memory that is kept to the next, and from one picture to the next.
        look: Makes a picture of what is there, from the latest observation; the first one is of the
            start, the last one of the end.
        beyond: Whether to keep also what the policy would do after the end.
    """
    start = env.reset(**reset)
    pictures = [look(start[0])] if look is not None else []
    memories, infos = [], []

    # Keep what the policy remembers and what the environment tells, every so many steps.
    steps = islice(run_episodes(policy, env, start), horizon)
    for number, step in enumerate(track(steps, "episode"), 1):
        if (number - 1) % stride == 0:
            memories.append(step.memory)
            infos.append(step.before)
        if look is not None and (number % stride == 0 or step.ended.all()):
            pictures.append(look(step.next_observation))

    # What there is after the last step, and only the one episode of a batch.
    infos.append(step.info)
    if beyond:
        memories.append(policy.predict(step.next_observation, step.memory)[1])
    if isinstance(env, VectorEnv):
        infos = [{name: values[0] for name, values in info.items()} for info in infos]
    env.close()
    success, (seed,) = bool(infos[-1]["is_success"]), np.ravel(reset["seed"]).tolist()
    return kind(policy, memories, success, infos, pictures, env.unwrapped, seed, stride)


def runs_of(items: Iterable[Any]) -> list[tuple[int, int]]:
    """First index of each run of equal items, and the first one after it."""
    runs, begin = [], 0
    for _, run in groupby(items):
        end = begin + len(list(run))
        runs.append((begin, end))
        begin = end
    return runs


def true_intervals(mask: BoolArray) -> list[tuple[int, int]]:
    """First index of each run of true values and the first one after it."""
    return [(begin, end) for begin, end in runs_of(mask.tolist()) if mask[begin]]


def to_array(tensor: Tensor) -> FloatArray:
    """A tensor as an array of doubles."""
    return tensor.numpy(force=True).astype(np.float64)


def track(items: Iterable[Item], description: str) -> Iterable[Item]:
    """The items, with a progress bar on a terminal."""
    with naming_extra():
        from tqdm import tqdm  # a recording that somebody else made does without
    return tqdm(items, desc=description, disable=None)
