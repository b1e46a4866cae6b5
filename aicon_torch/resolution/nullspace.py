"""Nullspace projection: the paper's rule for gradients that meet (Sect. "Adaptive Nullspaces")."""

import dataclasses
from dataclasses import dataclass
from typing import Literal

import torch
from torch import Tensor

from aicon_torch.resolution.base import GradientStack, Memory, RankedGradients, Resolution
from aicon_torch.resolution.exploration import Exploration
from aicon_torch.resolution.projectors import PROJECTORS
from aicon_torch.validation import (
    check_choice,
    check_flags,
    check_instance,
    check_not_negative,
    check_positive,
)
from aicon_torch.vectors import select


@dataclass(frozen=True)
class NullspaceProjection(Resolution):
    """Gradients by magnitude, each projected into the nullspaces of all before it (Eq. 3-8).

    With weights wᵢ = softmax(‖∇ᵢ‖/τ) and ĝᵢ = wᵢ ∇ᵢ/‖∇ᵢ‖, the strongest ĝ is taken first, the
    others lose their component along it, the strongest of what remains is taken next, and so on
    while degrees of freedom remain. The sum of what was taken changes no cost against the will of a
    stronger gradient *where it was resolved*. When the two strongest oppose each other, exploration
    replaces the sum, unless the quantity has one component, and so no nullspace to explore.

    The defaults are what the library ships; :meth:`as_in_paper` gives the text's.

    Attributes:
        temperature: τ of the softmax over magnitudes (Sect. "Stabilizing the Control Signal", 0.8);
            None keeps the magnitudes themselves.
        margin: By how much a gradient must exceed the one that held its rank before, to take it
            (the paper: 10 %).
        projector: ``"orthogonal"`` I − vvᵀ (Eq. 6), ``"qr"`` I − QQᵀ (Eq. 5) or ``"pinv"`` I − J⁺J
            (Eq. 4), which are equal, where J is one gradient; ``"none"`` adds without projecting.
        restore_magnitude: Whether a gradient that meets others further on gets the magnitude of the
            one that led here. The weights compare only those that met; the next quantity compares
            magnitudes. In the text what leaves is the sum as it is.
        relative: Whether the softmax is over magnitudes relative to the largest, so that their unit
            does not matter; without a softmax it has no effect. The text compares them as they are.
        by_row: Whether gradients through the same row of quantities whose rows go back to one
            quantity are summed before they meet others. In the text each is a candidate of its own.
        exploration: What to do about conflicts; None never explores.
    """

    temperature: float | None = 0.8
    margin: float = 0.1
    projector: Literal["orthogonal", "qr", "pinv", "none"] = "orthogonal"
    restore_magnitude: bool = True
    relative: bool = True
    by_row: bool = True
    exploration: Exploration | None = dataclasses.field(default_factory=Exploration)

    def __post_init__(self) -> None:
        """Check the options."""
        check_flags(self)
        check_not_negative(self, ("margin",))
        check_choice(self, "projector", tuple(PROJECTORS))
        if self.temperature is not None:
            check_positive(self, ("temperature",))
        if self.exploration is not None:
            check_instance(self, ("exploration",), Exploration, "Exploration()")

    @classmethod
    def as_in_paper(cls) -> "NullspaceProjection":
        """The text and nothing else, its exploration included."""
        exploration = Exploration.as_in_paper()
        return cls(restore_magnitude=False, relative=False, by_row=False, exploration=exploration)

    @property
    def goals(self) -> tuple[str, ...]:
        """Goals that the escape strategy names."""
        return self.exploration.escape.goals if self.exploration else ()

    def initial(self, count: int, size: int) -> Memory:
        """No gradient holds a rank yet (−1)."""
        memory = {"rank": torch.full((self._ranks(count, size),), -1)}
        exploration = self._exploration_among(size)
        if exploration is not None:
            memory |= exploration.initial(size)
        return memory

    def __call__(self, stack: GradientStack, memory: Memory) -> tuple[Tensor, Memory]:
        """The conflict-free sum, or the exploration that replaces it."""
        # 1. Normalise: directions and weights.
        magnitudes, directions, weights = self.normalize(stack.gradients)
        weighted = directions * weights.unsqueeze(-1)

        # 2. Order by magnitude and project (Eq. 7-8).
        strengths = torch.where(magnitudes > 0, weights, 0.0)  # what is zero asks for nothing
        projected, rank = self.project_in_order(weighted, strengths, held=memory["rank"])
        resolved = projected.sum(-2)
        new_memory = {"rank": rank}

        # 3. Give the sum back the magnitude of the dominant gradient, to be compared further on.
        dominant = rank[..., :1].clamp(min=0)
        restores = self.restore_magnitude and not stack.is_last
        if restores:
            dominant_magnitude = magnitudes.gather(-1, dominant)
            dominant_weight = weights.gather(-1, dominant)
            smallest = torch.finfo(magnitudes.dtype).tiny
            resolved = resolved * (dominant_magnitude / dominant_weight.clamp(min=smallest))

        # 4. Where the two strongest oppose each other, explore instead.
        exploration = self._exploration_among(stack.gradients.shape[-1])
        if exploration is not None:
            ranked = RankedGradients(magnitudes, directions, weights, weighted, dominant)
            exploring, direction, explored = exploration(stack, ranked, memory)
            if direction is not None:
                if restores:
                    direction = direction * dominant_magnitude
                resolved = torch.where(exploring.unsqueeze(-1), -direction, resolved)
            new_memory |= explored

        return resolved, new_memory

    def normalize(self, gradients: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Magnitudes ``(*B, n)``, directions ``(*B, n, d)`` and weights ``(*B, n)``."""
        magnitudes = torch.linalg.vector_norm(gradients, dim=-1)
        smallest = torch.finfo(magnitudes.dtype).tiny ** 0.5
        directions = gradients / magnitudes.clamp(min=smallest).unsqueeze(-1)

        return magnitudes, directions, self.weigh(magnitudes)

    def weigh(self, magnitudes: Tensor) -> Tensor:
        """Normalised magnitudes wᵢ ``(*B, n)``: their softmax."""
        if self.temperature is None:
            return magnitudes
        if self.relative:
            smallest = torch.finfo(magnitudes.dtype).tiny ** 0.5
            magnitudes = magnitudes / magnitudes.amax(-1, keepdim=True).clamp(min=smallest)
        return torch.softmax(magnitudes / self.temperature, dim=-1)

    def project_in_order(
        self, gradients: Tensor, magnitudes: Tensor, held: Tensor
    ) -> tuple[Tensor, Tensor]:
        """Greedy ordering by magnitude after projection (Eq. 7-8), with hysteresis.

        Args:
            gradients: ``(*B, n, d)``.
            magnitudes: Theirs, ``(*B, n)``.
            held: Which gradient held each rank in the last step, ``(*B, ranks)``.

        Returns:
            The selected gradients ``(*B, ranks, d)`` by rank, and the index of each, −1 where none
            was left. They are mutually orthogonal, unless nothing is projected.
        """
        project = PROJECTORS[self.projector]
        indices = torch.arange(gradients.shape[-2], device=gradients.device)
        ranks = held.shape[-1]
        selected: list[Tensor] = []
        selected_index: list[Tensor] = []
        selected_magnitude: list[Tensor] = []

        # By how much each is favoured for each rank: the one that held it before.
        held_it = (held.unsqueeze(-1) == indices).to(torch.float32)
        favours = (1.0 + self.margin * held_it).unbind(-2)

        for rank, favour in enumerate(favours):
            # The strongest comes next (Eq. 7).
            magnitude, index = (magnitudes * favour).max(-1, keepdim=True)
            strongest = select(gradients, index)
            selected.append(strongest)
            selected_index.append(index)
            selected_magnitude.append(magnitude)

            # The others lose their component along it (Eq. 8).
            if rank + 1 < ranks:
                is_taken = (indices == index).unsqueeze(-1)
                gradients = project(strongest, gradients).masked_fill(is_taken, 0.0)
                magnitudes = torch.linalg.vector_norm(gradients, dim=-1)

        # Where the strongest is zero, nothing was left.
        nothing_left = torch.cat(selected_magnitude, dim=-1) == 0
        index = torch.cat(selected_index, dim=-1).masked_fill(nothing_left, -1)
        return torch.stack(selected, dim=-2), index

    def _exploration_among(self, size: int) -> Exploration | None:
        """What explores a quantity of so many components; one alone has no nullspace."""
        return self.exploration if size > 1 else None

    def _ranks(self, count: int, size: int) -> int:
        """The degrees of freedom to be had, min(n, d); without projection n."""
        return count if self.projector == "none" else min(count, size)
