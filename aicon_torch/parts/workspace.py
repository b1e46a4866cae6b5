"""The edge of the workspace as a goal."""

from dataclasses import dataclass

import torch
from torch import Tensor

from aicon_torch.parts.chain import Chain
from aicon_torch.parts.hinge import Margin, SquaredHinge
from aicon_torch.parts.planar import norm
from aicon_torch.validation import check_positive

SAMPLES = 8192
"""Random postures of which the one that reaches farthest counts."""


@dataclass(frozen=True)
class Workspace(Margin):
    """g = w max(0, 1 − m/m₀)², where m is the distance of the tip to a circle about the base.

    At the edge the arm is straight: it cannot go on, and comes back with the elbow bent the other
    way, toward a stop.

    Attributes:
        radius: Radius of the circle, m.
        cost: Margin m₀ (m) and weight w.

    Raises:
        OptionError: If the radius is not positive.

    Example:
        >>> Goal("workspace", Workspace.of_chain(chain, SquaredHinge(margin=0.05, weight=1.0)))
    """

    radius: float
    cost: SquaredHinge

    def __post_init__(self) -> None:
        """Check the radius."""
        check_positive(self, ("radius",))

    @classmethod
    def of_chain(cls, chain: Chain, cost: SquaredHinge) -> "Workspace":
        """The workspace of an arm: as far from the base's axis as its tip came in random postures.

        Args:
            chain: The arm.
            cost: Margin m₀ (m) and weight w.
        """
        tips = chain(chain.postures(SAMPLES))[..., :2, 3]
        return cls(float(torch.linalg.vector_norm(tips, dim=-1).max()), cost)

    def __call__(self, x_ee: Tensor) -> Tensor:
        """The cost ``(*B,)`` of x_ee ``(*B, k)``, whose first two components are x and y, m."""
        return self.cost(self.distances(x_ee))

    def distances(self, x_ee: Tensor) -> Tensor:
        """The distance m to the circle, ``(*B, 1)``, m; negative beyond it."""
        return (self.radius - norm(x_ee[..., :2])).unsqueeze(-1)
