"""Goals: scalar costs on quantities, in any unit; the gradient of each is followed downhill."""

from collections.abc import Callable

import torch
from torch import Tensor

from aicon_torch.errors import GraphError, OptionError
from aicon_torch.interconnections import Interconnection, Node, Values
from aicon_torch.quantities import as_number
from aicon_torch.validation import check_flag

MOST_GAPS = 8
"""So many gaps of a safety goal bound an action, the smallest, unless its cost says otherwise."""


def factor_of(goal: str, factor: bool | float | Tensor, factors: Tensor) -> Tensor:
    """The factor by which a goal counts from now on.

    Args:
        goal: Name of the goal.
        factor: What was given: a number, or one for each row ``(*B,)``.
        factors: The factors of all goals, ``(*B, goals)``.

    Raises:
        OptionError: If it is none.
    """
    batch = tuple(factors.shape[:-1])
    try:
        value = torch.as_tensor(factor, dtype=factors.dtype, device=factors.device)
    except (TypeError, ValueError, RuntimeError):
        value = factors.new_full((), torch.nan)
    if tuple(value.shape) == (1,):  # one for all
        value = value.squeeze(0)
    if tuple(value.shape) not in ((), batch) or not (value.isfinite() & (value >= 0)).all():
        raise OptionError(
            f"{goal}={factor!r}: expected a finite factor >= 0, one for all or one a row, {batch}."
        )
    return value


class Goal(Node):
    """A scalar cost g(x) on the quantities that its function names.

    A *safety* goal is not followed: no action may raise its cost above the tolerance. Each of its
    gaps, what is left until it costs something, bounds the actions that act on it (see
    :class:`aicon_torch.dampers.VelocityDampers`). Its gradient meets no other and is never
    projected away, and exploration keeps its bounds. Its cost may have these methods, with the
    parameters of the cost:

    - ``gaps`` returns the gaps, ``(*B, m)``, of which only the smallest bound an action. Without
      it there is one, ε − g.
    - ``gap`` computes one of many gaps without the others; its last parameter is the number of
      that one, ``(*B,)``. Such a cost leaves out gaps that no action changes.
    - ``room`` returns how far each component of the actuator may go down and up, ``(*B, n)`` both,
      if each is bounded by itself: see :class:`aicon_torch.dampers.PlaceEscape`.

    Args:
        name: Name of the goal, by which it is switched and explained.
        cost: A function that returns the cost ``(*B,)``; lower is better.
        tolerance: ε, in the unit of the cost: a cost below it counts as none, max(0, g − ε).
        safety: Whether nothing may violate it.

    Raises:
        GraphError: If the cost is no function, or the tolerance is negative.
        OptionError: If safety is neither True nor False.

    Example:
        >>> def expected_distance(p_tar, P_tar):  # g₁ of the paper's navigation
        ...     return p_tar.norm(dim=-1) + P_tar.diagonal(dim1=-2, dim2=-1).sum(-1)
        >>> Goal("reach", expected_distance)
        >>> Goal("stops", JointLimits(low, high, SquaredHinge(0.02, 1.0)), safety=True)
    """

    def __init__(
        self,
        name: str,
        cost: Callable[..., Tensor] | Interconnection,
        *,
        tolerance: float = 0.0,
        safety: bool = False,
    ) -> None:
        super().__init__()
        check_flag(f"Goal {name!r}: safety", safety)
        if not isinstance(name, str):
            raise GraphError(f"Goal {name!r}: expected a name.")
        number = as_number(tolerance)
        if not number >= 0:
            raise GraphError(f"Goal {name!r}: tolerance={tolerance!r}; expected a number >= 0.")
        self.name, self.tolerance, self.safety = name, number, safety
        self.cost = Interconnection.of(cost, f"Goal {name!r}")
        self.inputs = self.cost.inputs

    def forward(self, values: Values) -> Tensor:
        """The cost, ``(*B,)``."""
        cost: Tensor = self.cost(values)
        return (cost - self.tolerance).clamp(min=0.0) if self.tolerance else cost

    def gaps(self, values: Values) -> Tensor:
        """What is left until it costs something, ``(*B, m)``; negative where it does."""
        # A cost may know its gaps; of any other there is one, ε − g.
        own: Callable[..., Tensor] | None = getattr(self.cost.function, "gaps", None)
        if own is not None:
            return own(*self._read(values))
        cost: Tensor = self.cost(values)
        return self.tolerance - cost.unsqueeze(-1)

    def gap(self, values: Values, which: Tensor) -> Tensor:
        """Some gaps by their numbers ``(m, *B)``, which may differ from row to row, ``(m, *B)``.

        The values are m copies of the same ones, ``(m, *B, …)``, so that each gap has derivatives
        of its own.
        """
        own: Callable[..., Tensor] | None = getattr(self.cost.function, "gap", None)
        if own is not None:
            return own(*self._read(values), which)
        return self.gaps(values).gather(-1, which.unsqueeze(-1)).squeeze(-1)

    @property
    def has_many_gaps(self) -> bool:
        """Whether it can compute one gap without the others, as a cost of many does."""
        return hasattr(self.cost.function, "gap")

    @property
    def most_gaps(self) -> int:
        """So many of its gaps bound an action at most, the smallest."""
        return int(getattr(self.cost.function, "most_gaps", MOST_GAPS))

    @property
    def has_room(self) -> bool:
        """Whether it says how far each component of the actuator may go."""
        return hasattr(self.cost.function, "room")

    def room(self, values: Values) -> tuple[Tensor, Tensor]:
        """How far each component may go down and up, ``(*B, n)`` both."""
        room: tuple[Tensor, Tensor] = self.cost.function.room(*self._read(values))
        return room

    def _read(self, values: Values) -> list[Tensor]:
        """What the cost reads, in the order of its parameters."""
        return [values[name] for name in self.inputs]
