"""Noise covariances, constant or a function of quantities."""

from collections.abc import Callable, Sequence

import torch
from torch import Tensor

from aicon_torch.errors import GraphError
from aicon_torch.interconnections import Interconnection, Node, Values
from aicon_torch.quantities import as_numbers

Noise = float | Sequence[float] | Callable[..., Tensor]
"""A variance, one a component, or a function of quantities that returns variances ``(*B, n)``."""


def covariance_name(mean: str) -> str:
    """P_tar of p_tar, P_ball of x_ball: what the covariance of an estimate is called."""
    return f"P_{mean.removeprefix('x_').removeprefix('p_')}"


class Covariance(Node):
    """The covariance of a noise, constant or a function of quantities wired by its parameter names.

    Args:
        noise: A variance, one variance a component, or a function that returns variances ``(*B,
            n)``.
        size: Number of components n.
        named: What an error calls the noise.
    """

    constant: Tensor

    def __init__(self, noise: Noise, size: int, named: str = "noise") -> None:
        super().__init__()
        if callable(noise):
            self.relation: Interconnection | None = Interconnection.of(noise, named)
            self.inputs = self.relation.inputs
            return

        self.relation, self.inputs = None, ()
        variances = torch.tensor(as_numbers(noise), dtype=torch.float64)
        has_right_size = variances.dim() == 0 or variances.shape == (size,)
        if not has_right_size or not ((variances >= 0) & variances.isfinite()).all():
            raise GraphError(
                f"{named}={noise!r}: expected one variance >= 0 or {size}, one a component."
            )

        # A matrix from the start, so that a step has nothing to build.
        self.size, self.is_single = size, variances.dim() == 0
        self.register_buffer("constant", torch.diag(variances.expand(size).clone()))

    def forward(self, values: Values) -> Tensor:
        """The covariance ``(n, n)`` or ``(*B, n, n)``."""
        if self.relation is None:
            return self.constant
        return torch.diag_embed(self.relation(values))
