"""Exploration: motion in the nullspace of a gradient while the two strongest oppose each other."""

import functools
from dataclasses import dataclass
from typing import Literal

import torch
from torch import Tensor

from aicon_torch.errors import OptionError
from aicon_torch.interconnections import Node
from aicon_torch.resolution.stack import GradientStack, Ranked
from aicon_torch.vectors import reject, select, unit


@dataclass(frozen=True)
class Escape:
    """What leaving a trap needs beyond the text. Every field is a deviation from it; all None is the paper.

    Each acts only at quantities where a gradient of the goal that it names arrives, alone or merged with others.

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
        ratio: λ of the paper.
        average_time: Time constant of the motion average, s.
        escape: What is done beyond the text.
        partner: Whether the dominant gradient is compared with the second strongest (the text), or with the strongest
            of those that oppose it, cos < θ_enter (θ_exit while exploring), which a conflict among three or more needs.
        ratio_of: Whether λ compares the normalised magnitudes or the magnitudes themselves.
    """

    def __init__(
        self,
        enter_cosine: float = -0.6,
        exit_cosine: float = -0.4,
        ratio: float = 3.0,
        average_time: float = 1.0,
        escape: Escape | None = None,
        partner: Literal["second", "opposing"] = "second",
        ratio_of: Literal["weights", "magnitudes"] = "weights",
    ) -> None:
        super().__init__()
        if not -1 <= enter_cosine <= exit_cosine <= 1:
            raise OptionError(
                f"enter_cosine={enter_cosine!r}, exit_cosine={exit_cosine!r}: expected -1 <= enter <= exit <= 1."
            )
        if not ratio >= 1 or not average_time > 0:
            raise OptionError(f"ratio={ratio!r}: expected >= 1; average_time={average_time!r}: expected > 0 (s).")
        if partner not in ("second", "opposing") or ratio_of not in ("weights", "magnitudes"):
            raise OptionError(
                f"partner={partner!r}, ratio_of={ratio_of!r}: "
                "expected 'second' or 'opposing', and 'weights' or 'magnitudes'."
            )
        self.partner, self.ratio_of = partner, ratio_of
        self.enter_cosine, self.exit_cosine = enter_cosine, exit_cosine
        self.ratio, self.average_time = ratio, average_time
        self.escape = escape or Escape()

    def initial(self, size: int) -> dict[str, Tensor]:
        """Not exploring, at rest."""
        memory = {"exploring": torch.tensor(False), "cosine": torch.tensor(0.0), "average": torch.zeros(size)}
        return memory | ({"displacement": torch.zeros(size)} if self.escape.progress else {})

    def forward(
        self, meeting: GradientStack, ranked: Ranked, memory: dict[str, Tensor]
    ) -> tuple[Tensor, Tensor, dict[str, Tensor]]:
        """Decide whether to explore, and where to.

        Args:
            meeting: The gradients that meet and what is known there.
            ranked: The same gradients by magnitude.
            memory: What was remembered of this quantity.

        Returns:
            Whether to explore ``(*B,)``, the unit direction of motion ``(*B, d)``, and the new memory.
        """
        cosine, decided = self.compare(ranked, memory["exploring"], meeting.siblings)
        rate = meeting.dt / (meeting.dt + self.average_time)
        state = {"cosine": cosine, "average": torch.lerp(memory["average"], meeting.motion, rate)}
        enter = (cosine < self.enter_cosine) & ~decided
        stay = (cosine <= self.exit_cosine) & ~decided
        if self.escape.progress:
            state["displacement"] = (memory["displacement"] + meeting.motion) * memory["exploring"].unsqueeze(-1)
            if self.escape.progress in meeting.concerned:
                before = meeting.displaced(self.escape.progress, -state["displacement"])
                stay = stay | (meeting.costs[self.escape.progress] >= before - self.escape.progress_margin)
        state["exploring"] = torch.where(memory["exploring"], stay, enter)
        return state["exploring"], self.direction(meeting, ranked, state["average"]), state

    def compare(self, ranked: Ranked, exploring: Tensor, siblings: Tensor | None = None) -> tuple[Tensor, Tensor]:
        """Cosine of the dominant gradient and its partner, and whether it exceeds the partner by λ, ``(*B,)`` each.

        Candidates that were resolved together before are no conflict, ``siblings`` ``(n, n)``.
        """
        rows = torch.arange(ranked.norms.shape[-1], device=ranked.first.device)
        strengths = ranked.weights if self.ratio_of == "weights" else ranked.norms
        first = select(ranked.units, ranked.first)
        others = strengths.masked_fill(rows == ranked.first, -1.0)
        if siblings is not None:
            others = others.masked_fill(siblings[ranked.first.squeeze(-1)], -1.0)
        if self.partner == "opposing":
            cosines = (first.unsqueeze(-2) * ranked.units).sum(-1)
            bound = torch.where(exploring, self.exit_cosine, self.enter_cosine).unsqueeze(-1)
            others = others.masked_fill(cosines > bound, -1.0)
        largest_other, partner = others.max(-1, keepdim=True)
        cosine = (first * select(ranked.units, partner)).sum(-1)
        cosine = torch.where(largest_other.squeeze(-1) < 0, 1.0, cosine)  # nothing opposes
        decided = strengths.gather(-1, ranked.first) > self.ratio * largest_other
        return cosine, decided.squeeze(-1)

    def direction(self, meeting: GradientStack, ranked: Ranked, average: Tensor) -> Tensor:
        """The unit direction in a nullspace that best continues the motion average, ``(*B, d)``."""
        normal = select(ranked.units, ranked.first)
        if self.escape.along in meeting.concerned:
            normal, _, _ = _of_goal(self.escape.along, meeting, ranked)
        axis = torch.arange(normal.shape[-1], device=normal.device) == normal.abs().argmin(-1, keepdim=True)
        free = reject(
            average - 1e-6 * ranked.scaled.sum(-2), normal
        )  # the descent decides where the average has no say
        direction = unit(reject(free + 1e-9 * axis, normal))  # and an axis where neither has; again, for rounding
        if self.escape.hold in meeting.concerned:
            held, strength, largest_other = _of_goal(self.escape.hold, meeting, ranked)
            excess = strength / largest_other.clamp(min=torch.finfo(strength.dtype).tiny) - 1.0
            direction = unit(direction - self.escape.hold_gain * excess.clamp(-1.0, 1.0).unsqueeze(-1) * held)
        return direction


PAPER = Exploration()
"""The paper's exploration, with none of the additions of an escape."""


def _of_goal(goal: str | None, meeting: GradientStack, ranked: Ranked) -> tuple[Tensor, Tensor, Tensor]:
    """Direction ``(*B, d)`` and magnitude of a goal's gradient here, and the largest magnitude of the others."""
    own = [index for index, goals in enumerate(meeting.goals) if goal in goals]
    others = [ranked.norms[..., index] for index in range(len(meeting.goals)) if index not in own]
    largest_other = functools.reduce(torch.maximum, others) if others else torch.zeros_like(ranked.norms[..., 0])
    if len(own) == 1:
        return ranked.units[..., own[0], :], ranked.norms[..., own[0]], largest_other
    total = meeting.gradients[..., own, :].sum(-2)
    return unit(total), torch.linalg.vector_norm(total, dim=-1), largest_other
