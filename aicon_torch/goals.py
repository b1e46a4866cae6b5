"""Goals: scalar costs on quantities, in any unit; the gradient of each is followed downhill."""

from collections.abc import Callable
from typing import cast

from torch import Tensor

from aicon_torch.interconnections import Interconnection, Node, Values


class Goal(Node):
    """A scalar cost g(x) on the quantities that its function names.

    Args:
        name: Name of the goal, by which it is switched and explained.
        cost: A function that returns the cost ``(*B,)``; lower is better.

    Example:
        >>> def expected_distance(p_tar, P_tar):  # g₁ of the paper's navigation
        ...     return p_tar.norm(dim=-1) + P_tar.diagonal(dim1=-2, dim2=-1).sum(-1)
        >>> Goal("reach", expected_distance)
    """

    def __init__(self, name: str, cost: Callable[..., Tensor] | Interconnection) -> None:
        super().__init__()
        self.name = name
        self.cost = Interconnection.of(cost)
        self.inputs = self.cost.inputs

    def forward(self, values: Values) -> Tensor:
        """The cost, ``(*B,)``."""
        return cast(Tensor, self.cost(values))
