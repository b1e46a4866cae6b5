"""What a resolution is given, and what it promises."""

from collections.abc import Callable, Mapping
from typing import ClassVar, NamedTuple

from torch import Tensor

Memory = dict[str, Tensor]
"""What lives from step to step, by name, each with the batch dimensions in front."""


class GradientStack(NamedTuple):
    """The gradients that meet at one quantity, and what is known there.

    Attributes:
        gradients: One row for each gradient, ``(*B, n, d)``.
        goals: For each gradient the goals that it comes from.
        motion: Latest motion of the quantity, ``(*B, d)``, per step.
        costs: Cost of each goal now, ``(*B,)``.
        displaced_cost: Cost of a goal now had the quantity been displaced,
            ``(goal, (*B, d)) -> (*B,)``.
        dt: Time step, s.
        is_last: Whether gradients meet nowhere else on the way from here to the actuators.
    """

    gradients: Tensor
    goals: tuple[frozenset[str], ...]
    motion: Tensor
    costs: Mapping[str, Tensor]
    displaced_cost: Callable[[str, Tensor], Tensor]
    dt: float
    is_last: bool = True

    @property
    def all_goals(self) -> frozenset[str]:
        """The goals whose gradients arrive here, alone or merged with others."""
        return frozenset().union(*self.goals)


class RankedGradients(NamedTuple):
    """The gradients of a stack taken apart into direction and weight, and which of them leads.

    Attributes:
        magnitudes: ‖∇ᵢ‖, ``(*B, n)``.
        directions: ∇ᵢ/‖∇ᵢ‖, ``(*B, n, d)``.
        weights: Normalised magnitudes wᵢ, ``(*B, n)``.
        weighted: wᵢ ∇ᵢ/‖∇ᵢ‖, ``(*B, n, d)``.
        dominant: Index of the dominant gradient, ``(*B, 1)``.
    """

    magnitudes: Tensor
    directions: Tensor
    weights: Tensor
    weighted: Tensor
    dominant: Tensor


class Resolution:
    """A rule from a stack of gradients ``(*B, n, d)`` to one gradient ``(*B, d)``.

    Attributes:
        merges: Whether it acts wherever gradients meet, so that one gradient leaves each quantity.
            Otherwise every path is followed to its end and the rule acts there.
        by_row: Whether gradients that come from the same row of quantities with rows are summed
            before they meet others.
    """

    merges: ClassVar[bool] = True
    by_row: bool = False

    @property
    def goals(self) -> tuple[str, ...]:
        """Goals that the rule's options name."""
        return ()

    def initial(self, count: int, size: int) -> Memory:
        """What the rule remembers before the first step, without batch dimensions.

        Args:
            count: Number n of gradients that meet.
            size: Number d of their components.
        """
        return {}

    def weigh(self, magnitudes: Tensor) -> Tensor:
        """By how much each gradient counts, ``(*B, n)``, from the magnitudes ``(*B, n)``."""
        return magnitudes

    def __call__(self, stack: GradientStack, memory: Memory) -> tuple[Tensor, Memory]:
        """The gradient that goes on, ``(*B, d)``, and the new memory."""
        raise NotImplementedError
