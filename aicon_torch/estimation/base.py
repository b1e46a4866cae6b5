"""Recursive estimators: modules that own quantities, update them, and say how they will change.

An estimator does two things in a step. ``update`` filters: it takes the last action and the new
readings and returns the new values; no gradient flows there. ``forward`` anticipates: from the new
values it gives the quantities that one more step would bring, differentiable by what moves them. So
the values are the measurement's and the gradient is the model's, evaluated at the best current
belief.
"""

from torch import Tensor

from aicon_torch.estimation.measurement import Innovation
from aicon_torch.interconnections import Node, Values


class Estimator(Node):
    """Base of all estimators.

    Attributes:
        outputs: Names of the quantities it owns.
        inputs: Names of what it reads. Its own outputs among them mean the values before the step.
        covariances: Those of its outputs that are covariances of others.
        is_motion: Whether its outputs are motions themselves (see :class:`aicon_torch.Quantity`).
        recursive: Whether it remembers its last values. Without, ``update`` and ``forward`` give
            the same value.
        each: Quantities with rows, for each row of which it is evaluated; its outputs then have
            rows as well.
        prior_inputs: What its initial values are read off.
    """

    outputs: tuple[str, ...]
    inputs: tuple[str, ...]
    covariances: tuple[str, ...] = ()
    is_motion: bool = False
    recursive: bool = True
    each: tuple[str, ...] = ()
    prior_inputs: tuple[str, ...] = ()

    def initial(self, values: Values) -> dict[str, Tensor]:
        """Values of the outputs before the first step, from the first readings."""
        raise NotImplementedError

    def check_sizes(self, values: Values) -> None:
        """Check the sizes of what the user gave, once, before it is first updated.

        Raises:
            GraphError: If some do not fit.
        """

    def check(self, values: Values) -> None:
        """Check what the user gave, such as Jacobians, once, when the graph is built.

        Args:
            values: A point at which to check it.

        Raises:
            GraphError: If it is wrong there.
        """

    def update(self, values: Values) -> dict[str, Tensor]:
        """The new outputs, from the values before the step, the last action and the readings."""
        raise NotImplementedError

    def filtered(self, values: Values) -> tuple[dict[str, Tensor], list[Innovation]]:
        """What :meth:`update` returns, and the innovations that it corrected by.

        It keeps no graph of its own accord: see :mod:`aicon_torch.differentiation`.
        """
        return self.update(values), []

    def forward(self, values: Values, output: str) -> Tensor:
        """One of the outputs one step ahead, differentiable by the values that need a gradient."""
        raise NotImplementedError
