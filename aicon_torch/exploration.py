"""Exploration: motion in the nullspace of a gradient while the two strongest oppose each other."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import TYPE_CHECKING

import torch
from torch import Tensor

from aicon_torch.errors import OptionError
from aicon_torch.interconnections import Node
from aicon_torch.vectors import reject, select, unit

if TYPE_CHECKING:
    from aicon_torch.resolution import Meeting


@dataclass(frozen=True)
class Escape:
    """What leaving a trap needs beyond the text. Every field is a deviation from it; all None is the paper.

    Attributes:
        progress: A goal whose cost must have fallen before exploration may end: its cost now against its cost had the
            quantity not moved since the conflict began, under the current belief.
        progress_margin: By how much it must have fallen, in the unit of the cost.
        hold: A goal whose level is held while exploring. Moving in a nullspace means staying on a level set, and
            discrete, noisy motion needs feedback for that. The level is where its gradient is as strong as the
            strongest of the others.
        hold_gain: Gain of that feedback, per relative error of the strength.
        along: A goal in whose nullspace to explore, instead of the dominant gradient's.
    """

    progress: str | None = None
    progress_margin: float = 0.1
    hold: str | None = None
    hold_gain: float = 3.0
    along: str | None = None

    @property
    def goals(self) -> tuple[str, ...]:
        """The goals that it names."""
        return tuple(goal for goal in (self.progress, self.hold, self.along) if goal is not None)


class Exploration(Node):
    """Conflict detection and nullspace exploration (Sect. "Escaping Local Minima").

    A conflict begins when the cosine of the two strongest gradients falls below ``enter_cosine``, and ends when it
    rises above ``exit_cosine`` or one exceeds all others by ``ratio``. Meanwhile the quantity moves along
    t = N m/‖N m‖, where N projects into the nullspace of the dominant gradient and m is the moving average of the
    quantity's motion. Where m has no component there, the descent directions decide, then the coordinate axes.

    Args:
        enter_cosine: θ_enter of the paper.
        exit_cosine: θ_exit of the paper.
        ratio: λ of the paper, on the normalised magnitudes.
        average_time: Time constant of the motion average, s.
        escape: What is done beyond the text.
    """

    def __init__(
        self,
        enter_cosine: float = -0.6,
        exit_cosine: float = -0.4,
        ratio: float = 3.0,
        average_time: float = 1.0,
        escape: Escape | None = None,
    ) -> None:
        super().__init__()
        if not -1 <= enter_cosine <= exit_cosine <= 1:
            raise OptionError(
                f"enter_cosine={enter_cosine!r}, exit_cosine={exit_cosine!r}: expected -1 <= enter <= exit <= 1."
            )
        if not ratio >= 1 or not average_time > 0:
            raise OptionError(f"ratio={ratio!r}: expected >= 1; average_time={average_time!r}: expected > 0 (s).")
        self.enter_cosine, self.exit_cosine = enter_cosine, exit_cosine
        self.ratio, self.average_time = ratio, average_time
        self.escape = escape or Escape()

    def initial(self, size: int) -> dict[str, Tensor]:
        """Not exploring, at rest."""
        memory = {"exploring": torch.tensor(False), "cosine": torch.tensor(0.0), "average": torch.zeros(size)}
        return memory | ({"displacement": torch.zeros(size)} if self.escape.progress else {})

    def forward(
        self,
        meeting: Meeting,
        norms: Tensor,
        units: Tensor,
        weights: Tensor,
        first: Tensor,
        resolved: Tensor,
        memory: dict[str, Tensor],
    ) -> tuple[Tensor, dict[str, Tensor]]:
        """Decide whether to explore, and replace the resolved gradient where so.

        Args:
            meeting: The gradients that meet and what is known there.
            norms: Their magnitudes, ``(*B, n)``.
            units: Their directions, ``(*B, n, d)``.
            weights: Their normalised magnitudes, ``(*B, n)``.
            first: Index of the dominant one, ``(*B, 1)``.
            resolved: The conflict-free gradient, ``(*B, d)``.
            memory: What was remembered of this quantity.

        Returns:
            The gradient ``(*B, d)``, whose negative is the direction of motion, and the new memory.
        """
        dominant = torch.arange(norms.shape[-1], device=first.device) == first
        rival, second = weights.masked_fill(dominant, -1.0).max(-1, keepdim=True)
        top = select(units, first)
        cosine = (top * select(units, second)).sum(-1)
        decided = (weights.gather(-1, first) > self.ratio * rival).squeeze(-1)
        average = memory["average"] + (meeting.motion - memory["average"]) * min(1.0, meeting.dt / self.average_time)
        state = {"cosine": cosine, "average": average}

        enter = (cosine < self.enter_cosine) & ~decided
        stay = (cosine <= self.exit_cosine) & ~decided
        if self.escape.progress:
            since = (memory["displacement"] + meeting.motion) * memory["exploring"].unsqueeze(-1)
            before = meeting.displaced(self.escape.progress, -since)
            stay = stay | (meeting.costs[self.escape.progress] >= before - self.escape.progress_margin)
            state["displacement"] = since
        exploring = torch.where(memory["exploring"], stay, enter)
        state["exploring"] = exploring

        normal = self._of_goal(self.escape.along, meeting, units, top)
        direction = self._along(normal, average, units * weights.unsqueeze(-1))
        if self.escape.hold:
            direction = self._holding(self.escape.hold, direction, meeting, norms, units)
        return torch.where(exploring.unsqueeze(-1), -direction, resolved), state

    @staticmethod
    def _of_goal(goal: str | None, meeting: Meeting, units: Tensor, otherwise: Tensor) -> Tensor:
        """The direction of a goal's gradient at this quantity, ``(*B, d)``."""
        for index, goals in enumerate(meeting.goals):
            if goals == {goal}:
                return units[..., index, :]
        return otherwise

    @staticmethod
    def _along(normal: Tensor, average: Tensor, scaled: Tensor) -> Tensor:
        """The unit direction in the nullspace of ``normal`` that best continues the motion average, ``(*B, d)``."""
        axis = torch.arange(normal.shape[-1], device=normal.device) == normal.abs().argmin(-1, keepdim=True)
        free = reject(average - 1e-6 * scaled.sum(-2), normal)  # the descent decides where the average has no say
        return unit(reject(free + 1e-9 * axis, normal))  # and an axis where it has none; rejects rounding errors, too

    def _holding(self, goal: str, direction: Tensor, meeting: Meeting, norms: Tensor, units: Tensor) -> Tensor:
        """The direction plus feedback toward the level where the goal's gradient balances the strongest other."""
        for index, goals in enumerate(meeting.goals):
            if goals == {goal}:
                rivals = [norms[..., other] for other in range(norms.shape[-1]) if other != index]
                strongest = functools.reduce(torch.maximum, rivals).clamp(min=torch.finfo(norms.dtype).tiny)
                strength = norms[..., index] / strongest
                error = (strength - 1.0).clamp(-1.0, 1.0).unsqueeze(-1)
                held = direction - self.escape.hold_gain * error * units[..., index, :]
                return unit(held)
        return direction
