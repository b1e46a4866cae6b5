"""What the recordings of all tasks have in common: the memories of an episode, traced at once."""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, TypeVar

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from aicon_baselines.extras import missing_extra
from aicon_torch.inspection import QuantityTrace, StepTrace
from aicon_torch.policy import Policy
from aicon_torch.resolution import Memory

try:
    from tqdm import tqdm
except ModuleNotFoundError as error:
    raise missing_extra(error) from error

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

Item = TypeVar("Item")


@dataclass(frozen=True, kw_only=True)
class Recording:
    """An episode and what the policy knew in it, with m memories at regular times.

    Attributes:
        seed: Seed of the episode.
        policy: The policy.
        memories: The memories, the first one of the first step.
        ending: How the episode ended.
        stride: Steps from one memory to the next.
    """

    resolved_at: ClassVar[str]
    """The quantity at which the gradients that the figure shows are resolved."""

    seed: int
    policy: Policy
    memories: list[Memory]
    ending: str
    stride: int = 1

    @property
    def time_step(self) -> float:
        """Time from one memory to the next, s."""
        return self.stride * self.policy.model.dt

    @property
    def steps(self) -> int:
        """Number of memories whose action was carried out, n ≤ m."""
        return len(self.memories)

    @cached_property
    def times(self) -> FloatArray:
        """When each memory was computed, (m,), s."""
        return np.arange(len(self.memories), dtype=np.float64) * self.time_step

    @cached_property
    def trace(self) -> StepTrace:
        """What the policy knew and decided, with all memories as one batch (m,)."""
        first = self.memories[0]
        batch = {key: torch.stack([memory[key] for memory in self.memories]) for key in first}
        return self.policy.trace(batch)

    @property
    def resolution(self) -> QuantityTrace:
        """What happened where the gradients were resolved."""
        return self.trace.quantities[self.resolved_at]

    @cached_property
    def exploring(self) -> BoolArray:
        """Whether it was exploring, (m,)."""
        return self.resolution.exploring.numpy(force=True)

    @cached_property
    def explorations(self) -> list[tuple[int, int]]:
        """First step of each exploration and the first one after it."""
        return true_intervals(self.exploring[: self.steps])


def true_intervals(mask: BoolArray) -> list[tuple[int, int]]:
    """First index of each run of true values and the first one after it."""
    padded = np.concatenate([[False], mask, [False]])
    edges = np.flatnonzero(padded[1:] != padded[:-1])
    return [(int(begin), int(end)) for begin, end in edges.reshape(-1, 2)]


def to_array(tensor: Tensor) -> FloatArray:
    """A tensor as an array of doubles."""
    return tensor.numpy(force=True).astype(np.float64)


def track(items: Iterable[Item], description: str, show: bool) -> Iterable[Item]:
    """The items, with a progress bar on a terminal if it is to be shown."""
    return tqdm(items, desc=description, disable=None if show else True)
