"""The edge of the workspace as a goal."""

from dataclasses import dataclass

import torch
from torch import Tensor

from aicon_torch.parts.hinge import SquaredHinge


@dataclass(frozen=True)
class Workspace:
    """g = w max(0, 1 − m/m₀)², where m is the distance of the tip to a circle about the base.

    At the edge the arm is straight: it cannot go on, and comes back with the elbow bent the other
    way, toward a stop.

    Attributes:
        radius: Radius of the circle, m.
        cost: Margin m₀ (m) and weight w.
    """

    radius: float
    cost: SquaredHinge

    def __call__(self, x_ee: Tensor) -> Tensor:
        """The cost ``(*B,)`` of x_ee ``(*B, k)``, whose first two components are x and y, m."""
        x, y = x_ee[..., 0], x_ee[..., 1]
        distance = torch.sqrt(x * x + y * y + 1e-18)  # differentiable on the base's axis, too
        return self.cost((self.radius - distance).unsqueeze(-1))
