"""Resolutions: what happens to the gradients that meet at a quantity."""

import math
from collections.abc import Callable
from typing import Literal

import torch
from torch import Tensor

from aicon_torch.errors import OptionError, choices
from aicon_torch.resolution.exploration import PAPER, Exploration
from aicon_torch.interconnections import Node
from aicon_torch.resolution.stack import GradientStack, Ranked
from aicon_torch.vectors import reject, select, unit

Memory = dict[str, Tensor]


class Resolution(Node):
    """A rule from a stack of gradients ``(*B, n, d)`` to one gradient ``(*B, d)``.

    Attributes:
        merges: Whether it acts wherever gradients meet, so that one gradient leaves each quantity. Otherwise every
            path is followed to its end and the rule acts there.
        by_row: Whether gradients that come from the same row of quantities with rows are summed before they meet.
        inherits: Whether what is resolved at a quantity goes on as ranked gradients instead of as one, where it meets
            others again.
    """

    merges = True
    by_row = False
    inherits = False

    @property
    def goals(self) -> tuple[str, ...]:
        """Goals that the rule's options name."""
        return ()

    def initial(self, candidates: int, size: int) -> Memory:
        """What the rule remembers at a quantity with n candidates of d components, before the first step."""
        return {}

    def ranks(self, candidates: int, size: int) -> int:
        """How many of n candidates of d components are used."""
        return candidates

    def forward(self, meeting: GradientStack, memory: Memory) -> tuple[Tensor, Memory]:
        """The gradient that goes on, ``(*B, d)``, and the new memory.

        With `inherits` these are the ranked gradients, ``(*B, ranks, d)``, unless the meeting is final.
        """
        raise NotImplementedError


class Sum(Resolution):
    """Σᵢ ∇ᵢ: plain backpropagation, whose descent is that of a potential field."""

    def forward(self, meeting: GradientStack, memory: Memory) -> tuple[Tensor, Memory]:
        """The sum of the gradients."""
        return meeting.gradients.sum(-2), memory


class SteepestPath(Resolution):
    """∇ of p* = argmax ‖∇ᵖ‖ over complete paths (Eq. 2), the rule of the original AICON."""

    merges = False

    def initial(self, candidates: int, size: int) -> Memory:
        """No path was taken yet (−1)."""
        return {"rank": torch.full((1,), -1)}

    def forward(self, meeting: GradientStack, memory: Memory) -> tuple[Tensor, Memory]:
        """The longest of the gradients."""
        steepest = torch.linalg.vector_norm(meeting.gradients, dim=-1).argmax(-1, keepdim=True)
        return select(meeting.gradients, steepest), {"rank": steepest}


class NullspaceProjection(Resolution):
    """Gradients ordered by strength, each projected into the nullspaces of all before it, then added (Eq. 3-8).

    With weights wᵢ = softmax(‖∇ᵢ‖/τ) and ĝᵢ = wᵢ ∇ᵢ/‖∇ᵢ‖, the strongest ĝ is taken first, the others lose their
    component along it, the strongest of what remains is taken next, and so on while degrees of freedom remain. The sum
    of what was taken changes no cost against the will of a stronger gradient *where it was resolved*. When the two
    strongest oppose each other, exploration replaces the sum.

    Args:
        temperature: τ of the softmax over magnitudes (Sect. "Stabilizing the Control Signal", 0.8); None keeps the
            magnitudes themselves.
        margin: By how much a gradient must exceed the one that held its rank before, to take it (the paper: 10 %).
        projector: ``"orthogonal"`` I − vvᵀ (Eq. 6), ``"qr"`` I − QQᵀ (Eq. 5) or ``"pinv"`` I − J⁺J (Eq. 4), which are
            equal for scalar goals; ``"none"`` adds without projecting.
        restore_magnitude: Whether a gradient that meets others again further on gets the magnitude of the one that led
            here. The weights compare only those that met; the next meeting compares magnitudes. The text does not say.
        relative: Whether the softmax is over magnitudes relative to the largest, so that their unit does not matter;
            without a softmax it has no effect.
        by_row: Whether gradients through the same row of quantities whose rows go back to one quantity are summed
            before they meet. In the text each is a candidate of its own.
        merge: What goes on from a meeting to the next one. ``"sum"``: the sum of the projected gradients, as in the
            text. ``"order"``: each of them, to be projected again there, behind those that came before it here; so the
            order is that of the first meeting, and a stronger gradient keeps its nullspace across a coupling that is
            no isometry.
        exploration: What to do about conflicts, by default the paper's; None never explores.
    """

    def __init__(
        self,
        temperature: float | None = 0.8,
        margin: float = 0.1,
        projector: Literal["orthogonal", "qr", "pinv", "none"] = "orthogonal",
        restore_magnitude: bool = True,
        relative: bool = False,
        by_row: bool = False,
        merge: Literal["sum", "order"] = "sum",
        exploration: Exploration | None = PAPER,
    ) -> None:
        super().__init__()
        if temperature is not None and not 0 < temperature < math.inf:
            raise OptionError(f"temperature={temperature!r}: expected a positive number, or None for no softmax.")
        if not 0 <= margin < math.inf:
            raise OptionError(f"margin={margin!r}: expected a number >= 0.")
        if projector not in PROJECTORS:
            raise OptionError(f"projector={projector!r}: expected one of {choices(PROJECTORS)}.")
        if merge not in ("sum", "order"):
            raise OptionError(f"merge={merge!r}: expected 'sum' or 'order'.")
        self.temperature, self.margin = temperature, margin
        self.restore_magnitude = restore_magnitude
        self.relative, self.by_row, self.inherits = relative, by_row, merge == "order"
        self.project = PROJECTORS[projector]
        self.exploration = exploration

    @property
    def goals(self) -> tuple[str, ...]:
        """Goals that the escape strategy names."""
        return self.exploration.escape.goals if self.exploration else ()

    def initial(self, candidates: int, size: int) -> Memory:
        """No candidate holds a rank yet (−1)."""
        memory = {"rank": torch.full((self.ranks(candidates, size),), -1)}
        return memory | (self.exploration.initial(size) if self.exploration else {})

    def ranks(self, candidates: int, size: int) -> int:
        """The degrees of freedom to be had, min(n, d); without projection n."""
        return candidates if self.project is keep else min(candidates, size)

    def forward(self, meeting: GradientStack, memory: Memory) -> tuple[Tensor, Memory]:
        """The conflict-free sum, or the exploration that replaces it."""
        norms = torch.linalg.vector_norm(meeting.gradients, dim=-1)
        units = meeting.gradients / norms.clamp(min=torch.finfo(norms.dtype).tiny ** 0.5).unsqueeze(-1)
        weights = self.weigh(norms)
        scaled = units * weights.unsqueeze(-1)
        taken, rank = self.resolve(scaled, weights, memory["rank"], meeting.before)
        resolved = taken if self.inherits and not meeting.final else taken.sum(-2)
        state = {"rank": rank}
        ranked = Ranked(norms, units, weights, scaled, first=rank[..., :1].clamp(min=0))
        if self.restore_magnitude and not meeting.final:
            lead = norms.gather(-1, ranked.first)
            factor = lead / weights.gather(-1, ranked.first).clamp(min=torch.finfo(norms.dtype).tiny)
            resolved = resolved * (factor.unsqueeze(-1) if self.inherits else factor)
        if self.exploration is not None:
            exploring, direction, explored = self.exploration(meeting, ranked, memory)
            if self.restore_magnitude and not meeting.final:
                direction = direction * lead
            if resolved.dim() > direction.dim():  # one gradient leads, and no other is left
                alone = torch.nn.functional.pad(-direction.unsqueeze(-2), (0, 0, 0, resolved.shape[-2] - 1))
                resolved = torch.where(exploring[..., None, None], alone, resolved)
            else:
                resolved = torch.where(exploring.unsqueeze(-1), -direction, resolved)
            state |= explored
        return resolved, state

    def weigh(self, norms: Tensor) -> Tensor:
        """Normalised magnitudes ``(*B, n)``: their softmax."""
        if self.temperature is None:
            return norms
        if self.relative:
            norms = norms / norms.amax(-1, keepdim=True).clamp(min=torch.finfo(norms.dtype).tiny ** 0.5)
        return torch.softmax(norms / self.temperature, dim=-1)

    def resolve(
        self, gradients: Tensor, strengths: Tensor, held: Tensor, before: Tensor | None = None
    ) -> tuple[Tensor, Tensor]:
        """Greedy ordering by strength after projection (Eq. 7-8), with hysteresis.

        Args:
            gradients: ``(*B, n, d)``.
            strengths: Their norms, ``(*B, n)``.
            held: Which candidate held each rank in the last step, ``(*B, min(n, d))``.
            before: Which candidates j come before candidate i, whatever their strengths, ``(n, n)``.

        Returns:
            The selected, mutually orthogonal gradients ``(*B, min(n, d), d)`` by rank, and the candidate of each, −1
            where none was left.
        """
        ranks: list[Tensor] = []
        taken: list[Tensor] = []
        depth = held.shape[-1]
        candidates = torch.arange(gradients.shape[-2], device=gradients.device)
        for rank in range(depth):
            favour = 1.0 + self.margin * (candidates == held[..., rank : rank + 1])
            ready = strengths * favour
            if before is not None:
                ready = ready.masked_fill((before & (strengths > 0).unsqueeze(-2)).any(-1), -1.0)
            strength, index = ready.max(-1, keepdim=True)
            top = select(gradients, index)
            taken.append(top)
            if rank + 1 < depth:
                chosen = candidates == index
                gradients = self.project(top, gradients).masked_fill(chosen.unsqueeze(-1), 0.0)
                strengths = torch.linalg.vector_norm(gradients, dim=-1)
            ranks.append(index.masked_fill(strength == 0, -1))  # nothing is left to hold this rank
        return torch.stack(taken, dim=-2), torch.cat(ranks, dim=-1)


def orthogonal(top: Tensor, gradients: Tensor) -> Tensor:
    """(I − vvᵀ) ∇ with v = top/‖top‖ (Eq. 6).

    Args:
        top: The gradient of higher priority, ``(*B, d)``.
        gradients: Those to project, ``(*B, n, d)``.
    """
    return reject(gradients, unit(top).unsqueeze(-2))


def qr(top: Tensor, gradients: Tensor) -> Tensor:
    """(I − QQᵀ) ∇ with Jᵀ = QR (Eq. 5); a gradient that is zero takes nothing away."""
    q = torch.linalg.qr(top.unsqueeze(-1)).Q
    q = q * (top != 0).any(-1)[..., None, None]
    projected: Tensor = gradients - (gradients @ q) @ q.mT
    return projected


def pinv(top: Tensor, gradients: Tensor) -> Tensor:
    """(I − J⁺J) ∇ (Eq. 4)."""
    jacobian = top.unsqueeze(-2)
    projected: Tensor = gradients - (gradients @ torch.linalg.pinv(jacobian)) @ jacobian
    return projected


def keep(top: Tensor, gradients: Tensor) -> Tensor:
    """∇ as it is: without projection the result is a weighted sum."""
    return gradients


PROJECTORS: dict[str, Callable[[Tensor, Tensor], Tensor]] = {
    "orthogonal": orthogonal,
    "qr": qr,
    "pinv": pinv,
    "none": keep,
}
