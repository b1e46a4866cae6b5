"""Escape: what leaving a trap needs beyond the paper's text."""

import functools
from collections.abc import Sequence
from dataclasses import dataclass

import torch
from torch import Tensor

from aicon_torch.errors import OptionError
from aicon_torch.resolution.base import GradientStack, RankedGradients
from aicon_torch.validation import check_flags, check_not_negative
from aicon_torch.vectors import reject, unit


@dataclass(frozen=True)
class TrapEscape:
    """What leaving a trap needs beyond the text; with all fields None it is the paper.

    Each acts only at quantities where a gradient of the goal that it names arrives, alone or merged
    with others.

    Attributes:
        progress: A goal whose cost must have fallen before exploration may end: its cost now
            against its cost had the quantity not moved since the conflict began, under the current
            belief.
        progress_margin: By how much it must have fallen, in the unit of the cost.
        hold: A goal, or several, whose level is held while exploring. Moving in a nullspace means
            staying on a level set, and discrete, noisy motion needs feedback for that. The level is
            where its gradient is as strong as the strongest of the others.
        hold_gain: Gain of that feedback, per relative error of the magnitude.
        along: A goal, or several, in whose common nullspace to explore, instead of the dominant
            gradient's.
        onward: Whether it goes on in the direction in which it explored last, as that nullspace
            turns, and not in that of the motion average, which in an inner corner points back into
            the corner along either wall.

    Example:
        >>> TrapEscape(progress="reach", hold=("stops", "collision"), along=("stops", "collision"))
    """

    progress: str | None = None
    progress_margin: float = 0.1
    hold: str | Sequence[str] | None = None
    hold_gain: float = 3.0
    along: str | Sequence[str] | None = None
    onward: bool = False

    def __post_init__(self) -> None:
        """Check numbers and flags."""
        check_flags(self)
        check_not_negative(self, ("progress_margin", "hold_gain"))
        for name, kinds in (("progress", str), ("hold", str | Sequence), ("along", str | Sequence)):
            goals = getattr(self, name)
            if goals is not None and not isinstance(goals, kinds):
                raise OptionError(f"{name}={goals!r}: expected a goal by its name, or None.")

    @property
    def goals(self) -> tuple[str, ...]:
        """The goals that it names."""
        return (*_names(self.progress), *_names(self.hold), *_names(self.along))

    def waits_for_progress(self, stack: GradientStack, displacement: Tensor) -> Tensor | None:
        """Whether the goal ``progress`` is no better than where exploring began, ``(*B,)``.

        Args:
            stack: The gradients that meet.
            displacement: Motion of the quantity since exploring began, ``(*B, d)``.

        Returns:
            None where that goal is not named or does not arrive here.
        """
        if self.progress is None or self.progress not in stack.all_goals:
            return None
        cost_at_start = stack.displaced_cost(self.progress, -displacement)
        return stack.costs[self.progress] >= cost_at_start - self.progress_margin

    def normals(self, stack: GradientStack, ranked: RankedGradients) -> list[Tensor]:
        """The directions in whose nullspace to explore, ``(*B, d)`` each and at right angles.

        If there are none, exploration takes the dominant gradient's direction instead.
        """
        normals: list[Tensor] = []
        for goal in _names(self.along):
            if goal not in stack.all_goals:
                continue
            direction, _, _ = _gradient_of(goal, stack, ranked)

            # At right angles to those before it, so that they can be taken away one by one.
            if normals:
                for earlier in normals:
                    direction = reject(direction, earlier)
                direction = unit(direction)
            normals.append(direction)
        return normals

    def hold_level(self, tangent: Tensor, stack: GradientStack, ranked: RankedGradients) -> Tensor:
        """A direction of motion ``(*B, d)``, led back to the levels that are held."""
        held_goals = [goal for goal in _names(self.hold) if goal in stack.all_goals]
        if not held_goals:
            return tangent

        led_back = tangent
        for goal in held_goals:
            held, magnitude, largest_other = _gradient_of(goal, stack, ranked)
            smallest = torch.finfo(magnitude.dtype).tiny

            # Down its gradient where that is stronger than the others, up where it is weaker.
            excess = magnitude / largest_other.clamp(min=smallest) - 1.0
            led_back = led_back - self.hold_gain * excess.clamp(-1.0, 1.0).unsqueeze(-1) * held
        return unit(led_back)


def _names(option: str | Sequence[str] | None) -> tuple[str, ...]:
    """The goals that an option names: none, one or several."""
    if option is None:
        return ()
    return (option,) if isinstance(option, str) else tuple(option)


def _gradient_of(
    goal: str, stack: GradientStack, ranked: RankedGradients
) -> tuple[Tensor, Tensor, Tensor]:
    """Direction ``(*B, d)`` and magnitude of a goal's gradient, and the largest of the others."""
    own: list[int] = []
    other_magnitudes: list[Tensor] = []
    for index, goals in enumerate(stack.goals):
        if goal in goals:
            own.append(index)
        else:
            other_magnitudes.append(ranked.magnitudes[..., index])

    largest_other = torch.zeros_like(ranked.magnitudes[..., 0])
    if other_magnitudes:
        largest_other = functools.reduce(torch.maximum, other_magnitudes)

    # Where a goal arrives by several paths, it asks for their sum.
    if len(own) == 1:
        return ranked.directions[..., own[0], :], ranked.magnitudes[..., own[0]], largest_other
    total = stack.gradients[..., own, :].sum(-2)
    return unit(total), torch.linalg.vector_norm(total, dim=-1), largest_other
