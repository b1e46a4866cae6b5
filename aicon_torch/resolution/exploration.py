"""Exploration: motion in the nullspace of a gradient while the two strongest oppose each other."""

from dataclasses import dataclass, field
from typing import Literal, NamedTuple

import torch
from torch import Tensor

from aicon_torch.differentiation import is_nowhere
from aicon_torch.errors import OptionError
from aicon_torch.resolution.base import GradientStack, Memory, RankedGradients
from aicon_torch.resolution.escape import TrapEscape
from aicon_torch.validation import check_flags, check_instance, check_positive, numbers
from aicon_torch.vectors import reject, select, unit


class Comparison(NamedTuple):
    """The dominant gradient beside the one that it is compared with.

    Attributes:
        cosine: Cosine between the two, ``(*B,)``; 1 where there is none to compare with.
        opponent: Index of the other one, ``(*B, 1)``; −1 where there is none.
        is_decided: Whether the dominant one exceeds it by λ, ``(*B,)``.
    """

    cosine: Tensor
    opponent: Tensor
    is_decided: Tensor


@dataclass(frozen=True)
class Exploration:
    """Conflict detection and nullspace exploration (Sect. "Escaping Local Minima").

    It is decided for each quantity where gradients meet, and for each row of the batch. The
    dominant gradient is compared with its opponent, the second strongest or the strongest that
    opposes it:

    - it begins when their cosine is below ``enter_cosine`` and the dominant one is not more
      than ``ratio`` times as strong as its opponent;
    - it goes on while their cosine is at most ``exit_cosine`` and the dominant one is not more
      than ``ratio`` times as strong, or, beyond the text, while ``escape`` waits for progress;
    - it ends when neither holds, or when a new episode begins.

    Meanwhile the quantity moves along t = N m/‖N m‖, where N projects into the nullspace of the
    dominant gradient and m is the moving average of the quantity's motion. Where m has no component
    there, the descent directions decide, then the coordinate axes.

    The defaults are what the library ships; :meth:`as_in_paper` gives the text's.

    Attributes:
        enter_cosine: θ_enter of the paper.
        exit_cosine: θ_exit of the paper.
        ratio: λ of the paper.
        average_time: Time constant of the motion average, s.
        escape: What is done beyond the text.
        opponent: Whether the dominant gradient is compared with the second strongest (the text), or
            with the strongest of those that oppose it, cos < θ_enter (θ_exit while exploring),
            which a conflict among three or more needs.
        ratio_of: Whether λ compares the normalised magnitudes (the text) or the magnitudes
            themselves.
        unless_tracking: Whether it does not begin, beyond the text, where standing still would have
            cost more than the dominant slope explains: :meth:`is_tracking`. Then the quantity keeps
            up with something that moves, or comes to rest where many goals are balanced.
    """

    enter_cosine: float = -0.6
    exit_cosine: float = -0.4
    ratio: float = 3.0
    average_time: float = 0.4
    escape: TrapEscape = field(default_factory=TrapEscape)
    opponent: Literal["second", "opposing"] = "opposing"
    ratio_of: Literal["weights", "magnitudes"] = "magnitudes"
    unless_tracking: bool = False

    def __post_init__(self) -> None:
        """Check the options."""
        check_flags(self)
        check_positive(self, ("ratio", "average_time"))
        check_instance(self, ("escape",), TrapEscape, "TrapEscape()")

        for name in ("enter_cosine", "exit_cosine"):
            numbers(name, getattr(self, name), 1)
        if not -1 <= self.enter_cosine <= self.exit_cosine <= 1:
            raise OptionError(
                f"enter_cosine={self.enter_cosine!r}, exit_cosine={self.exit_cosine!r}: "
                "expected -1 <= enter <= exit <= 1."
            )
        if self.ratio < 1:
            raise OptionError(f"ratio={self.ratio!r}: expected a number >= 1.")
        if self.opponent not in ("second", "opposing"):
            raise OptionError(f"opponent={self.opponent!r}: expected 'second' or 'opposing'.")
        if self.ratio_of not in ("weights", "magnitudes"):
            raise OptionError(f"ratio_of={self.ratio_of!r}: expected 'weights' or 'magnitudes'.")

    @classmethod
    def as_in_paper(cls) -> "Exploration":
        """The text and nothing else; for the average, whose time it leaves open, 1 s."""
        return cls(average_time=1.0, opponent="second", ratio_of="weights")

    def initial(self, size: int) -> Memory:
        """Not exploring, at rest; what is remembered of a quantity with d components."""
        memory = {
            "exploring": torch.tensor(False),
            "cosine": torch.tensor(0.0),
            "opponent": torch.full((1,), -1),
            "average": torch.zeros(size),
        }
        if self.escape.progress:
            memory["displacement"] = torch.zeros(size)
        if self.escape.onward:
            memory["tangent"] = memory["normal"] = torch.zeros(size)
        return memory

    def __call__(
        self, stack: GradientStack, ranked: RankedGradients, memory: Memory
    ) -> tuple[Tensor, Tensor | None, Memory]:
        """Decide whether to explore, and where to.

        Args:
            stack: The gradients that meet and what is known there.
            ranked: The same gradients by magnitude.
            memory: What was remembered of this quantity.

        Returns:
            Whether to explore ``(*B,)``, the unit direction of motion ``(*B, d)``, None where it
            is known that no row explores, and the new memory.
        """
        # 1. The moving average of the quantity's motion.
        rate = stack.dt / (stack.dt + self.average_time)
        average = torch.lerp(memory["average"], stack.motion, rate)

        # 2. It begins where the two strongest oppose each other, and neither is much stronger.
        was_exploring = memory["exploring"]
        comparison = self.compare(ranked, was_exploring)
        enters = (comparison.cosine < self.enter_cosine) & ~comparison.is_decided
        if self.unless_tracking:
            enters = enters & ~self.is_tracking(stack, ranked, average)
        new_memory = {
            "cosine": comparison.cosine,
            "opponent": comparison.opponent,
            "average": average,
        }

        # How far it has moved since then, by which progress is measured.
        if self.escape.progress:
            moved = memory["displacement"] + stack.motion
            new_memory["displacement"] = moved * was_exploring.unsqueeze(-1)

        # 3. Where it has begun, it goes on (with hysteresis).
        exploring = enters
        if not is_nowhere(was_exploring):
            stays = self.stays(stack, comparison, new_memory)
            exploring = torch.where(was_exploring, stays, enters)
        new_memory["exploring"] = exploring

        # 4. Move along the nullspace.
        if is_nowhere(exploring) and not self.escape.onward:
            return exploring, None, new_memory
        normals = self.escape.normals(stack, ranked) or [select(ranked.directions, ranked.dominant)]
        before = average
        if self.escape.onward:
            onward = turned_with(memory["tangent"], memory["normal"], normals[0])
            before = torch.where(was_exploring.unsqueeze(-1), onward, average)
        tangent = self.tangent(ranked, normals, before)
        if self.escape.onward:
            new_memory |= {"tangent": tangent, "normal": normals[0]}
        return exploring, self.escape.hold_level(tangent, stack, ranked), new_memory

    def stays(self, stack: GradientStack, comparison: Comparison, memory: Memory) -> Tensor:
        """Whether exploration that has begun goes on, ``(*B,)``.

        Args:
            stack: The gradients that meet.
            comparison: The dominant one beside its opponent.
            memory: What is remembered from this step on.
        """
        stays = (comparison.cosine <= self.exit_cosine) & ~comparison.is_decided

        # Beyond the text: it ends only once there is progress.
        waits = None
        if self.escape.progress:
            waits = self.escape.waits_for_progress(stack, memory["displacement"])
        return stays if waits is None else stays | waits

    def compare(self, ranked: RankedGradients, exploring: Tensor) -> Comparison:
        """Set the dominant gradient against its opponent.

        Args:
            ranked: The gradients by magnitude.
            exploring: Whether the quantity explored in the last step, ``(*B,)``.
        """
        magnitudes = ranked.weights if self.ratio_of == "weights" else ranked.magnitudes
        dominant = select(ranked.directions, ranked.dominant)

        # The candidates are all other gradients; what is none gets the magnitude −1.
        indices = torch.arange(magnitudes.shape[-1], device=magnitudes.device)
        candidates = magnitudes.masked_fill(indices == ranked.dominant, -1.0)

        # Or only those that oppose the dominant one: cos ≤ θ_exit while exploring, else θ_enter.
        cosines = (dominant.unsqueeze(-2) * ranked.directions).sum(-1)
        if self.opponent == "opposing":
            largest: Tensor | float = self.enter_cosine
            if not is_nowhere(exploring):
                exit_cosine = cosines.new_tensor(self.exit_cosine)
                enter_cosine = cosines.new_tensor(self.enter_cosine)
                largest = torch.where(exploring, exit_cosine, enter_cosine).unsqueeze(-1)
            candidates = candidates.masked_fill(cosines > largest, -1.0)

        # The opponent is the strongest candidate.
        magnitude, opponent = candidates.max(-1, keepdim=True)
        is_alone = magnitude < 0
        cosine = cosines.gather(-1, opponent).masked_fill(is_alone, 1.0)

        is_decided = magnitudes.gather(-1, ranked.dominant) > self.ratio * magnitude
        return Comparison(
            cosine.squeeze(-1), opponent.masked_fill(is_alone, -1), is_decided.squeeze(-1)
        )

    def is_tracking(self, stack: GradientStack, ranked: RankedGradients, average: Tensor) -> Tensor:
        """Whether standing still would have cost more than the dominant slope explains, ``(*B,)``.

        That is Σᵢ cᵢ(x − d) − cᵢ(x) > ‖∇₁‖ ‖d‖ with the present costs cᵢ of the goals that meet
        and d, the motion within the time of the average. Where one goal leads into another, no
        path costs more than the steepest slope times its length; where many goals are balanced,
        their costs curve.
        """
        moved = average * (self.average_time / stack.dt)
        standing, here = (torch.zeros_like(average[..., 0]) for _ in range(2))
        for goal in sorted(stack.all_goals):
            standing = standing + stack.displaced_cost(goal, -moved)
            here = here + stack.costs[goal]

        slope = ranked.magnitudes.gather(-1, ranked.dominant).squeeze(-1)
        explained: Tensor = slope * torch.linalg.vector_norm(moved, dim=-1)
        return standing - here > explained

    def tangent(self, ranked: RankedGradients, normals: list[Tensor], before: Tensor) -> Tensor:
        """The unit direction in a nullspace that best continues the motion before, ``(*B, d)``."""
        # The motion so far decides; where it has no say the descent does, and else an axis.
        strength = ranked.weights.sum(-1, keepdim=True)
        smallest = torch.finfo(strength.dtype).tiny
        descent = -1e-6 * ranked.weighted.sum(-2) / strength.clamp(min=smallest)
        components = torch.arange(before.shape[-1], device=before.device)
        largest = torch.stack(normals).abs().amax(0)
        axis = 1e-9 * (components == largest.argmin(-1, keepdim=True)).to(torch.float32)
        free = _reject_all(before + descent, normals) + axis
        return unit(_reject_all(free, normals))


def turned_with(tangent: Tensor, normal: Tensor, new_normal: Tensor) -> Tensor:
    """A direction t, turned as its normal n turns to n′: t − (n + n′) (n′·t) / (1 + n·n′).

    So it goes on around a corner on the same side. Where the new normal is next to opposite, as
    between two walls, the direction stays.

    Args:
        tangent: t, ``(*B, d)``, at right angles to n.
        normal: n, ``(*B, d)``, of length one.
        new_normal: n′, likewise.
    """
    cosine = (normal * new_normal).sum(-1, keepdim=True)
    share = (new_normal * tangent).sum(-1, keepdim=True) / (1.0 + cosine).clamp(min=0.5)
    turned: Tensor = tangent - (normal + new_normal) * share
    return turned


def _reject_all(vector: Tensor, normals: list[Tensor]) -> Tensor:
    """A vector ``(*B, d)`` without its components along directions at right angles."""
    for normal in normals:
        vector = reject(vector, normal)
    return vector
