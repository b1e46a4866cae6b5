"""Estimators without memory: quantities that are a function of others."""

from collections.abc import Callable, Sequence

from torch import Tensor

from aicon_torch.differentiation import values_only
from aicon_torch.errors import GraphError, choices, in_order
from aicon_torch.estimation.base import Estimator
from aicon_torch.interconnections import Affine, Interconnection, Values
from aicon_torch.validation import check_flag


class Deterministic(Estimator):
    """A quantity y = f(x) without memory or uncertainty: an explicit interconnection defines it.

    Args:
        name: Name of the quantity.
        function: f; its parameter names are the quantities that it reads.
        is_motion: Whether the quantity is itself a motion, such as a displacement.
        each: Quantities ``(*B, N, k)`` for each row of which f is evaluated, so that f is written
            for one row and the quantity is ``(*B, N, n)``. Each row is a path of its own to
            whatever else f reads.

    Example:
        >>> def move(a, dt):
        ...     return a * dt  # m
        >>> Deterministic("x_rob", move, is_motion=True)
    """

    recursive = False

    def __init__(
        self,
        name: str,
        function: Callable[..., Tensor] | Interconnection,
        *,
        is_motion: bool = False,
        each: Sequence[str] = (),
    ) -> None:
        super().__init__()
        check_flag(f"Deterministic {name!r}: is_motion", is_motion)
        self.relation = Interconnection.of(function, f"Deterministic {name!r}")
        self.outputs = (name,)
        self.inputs = self.relation.inputs
        self.is_motion = is_motion

        if isinstance(each, str):
            raise GraphError(
                f"Deterministic {name!r}: each={each!r}; expected a sequence of names, such as "
                f"[{each!r}]."
            )
        self.each = in_order(f"each of {name!r}", each)

        # It must read what has the rows; dt has none.
        for rows in self.each:
            if rows not in self.inputs or rows == "dt":
                raise GraphError(
                    f"Deterministic {name!r}: each={rows!r}, but it reads {choices(self.inputs)}."
                )

        if name in self.inputs:
            raise GraphError(
                f"Deterministic {name!r} reads itself; what remembers its last value is an EKF "
                "or a KalmanFilter."
            )

    def initial(self, values: Values) -> dict[str, Tensor]:
        """Nothing is remembered."""
        return {}

    def check_sizes(self, values: Values) -> None:
        """Check that the terms of a linear relation have as many components."""
        if isinstance(self.relation, Affine):
            self.relation.components(values, f"Deterministic {self.outputs[0]!r}")

    @values_only
    def update(self, values: Values) -> dict[str, Tensor]:
        """The value ``(*B, n)``."""
        return {self.outputs[0]: self(values, self.outputs[0])}

    def forward(self, values: Values, output: str) -> Tensor:
        """The value, differentiable.

        With ``each``, a value may come with a copy for each row, or without.
        """
        if self.each:
            values = self._with_rows(values)
        value: Tensor = self.relation(values)
        return value

    def _with_rows(self, values: Values) -> Values:
        """What f reads, with a dimension for the rows where a value has none."""
        # What has fewer dimensions than the rows is shared by them; dt, a scalar, fits anyway.
        dimensions = values[self.each[0]].dim()
        expanded: dict[str, Tensor] = {}
        for name in self.inputs:
            value = values[name]
            is_shared = 0 < value.dim() < dimensions
            expanded[name] = value.unsqueeze(-2) if is_shared else value
        return expanded
