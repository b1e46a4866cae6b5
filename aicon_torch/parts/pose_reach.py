"""Reaching a pose as a goal."""

from dataclasses import dataclass

import torch
from torch import Tensor

from aicon_torch.parts.tip_pose import TipPose
from aicon_torch.validation import check_not_negative


@dataclass(frozen=True)
class PoseReach:
    """g = max(0, √(‖Δp‖² + L²θ²) − ε), for the distance ‖Δp‖ and the angle θ to a target pose.

    Where the orientation is free θ is 0, and where one axis matters it is the angle of the axes
    (see :class:`TipPose`, which has L). Within the tolerance it asks for nothing.

    Attributes:
        pose: What x_ee and the target are.
        tolerance: ε, m.

    Raises:
        OptionError: If the tolerance is negative.

    Example:
        >>> pose = TipPose("full", lever=0.2)
        >>> estimator = Deterministic("x_ee", EndEffector(chain, pose, damping=0.05))
        >>> goal = Goal("reach", PoseReach(pose, tolerance=0.001))
    """

    pose: TipPose
    tolerance: float = 0.0

    def __post_init__(self) -> None:
        """Check the tolerance."""
        check_not_negative(self, ("tolerance",))

    def __call__(self, x_ee: Tensor, x_target: Tensor) -> Tensor:
        """The cost ``(*B,)``, m, of a pose and its target, both ``(*B, k)``, m."""
        distance, angle = self.pose.distance(x_ee, x_target)
        turn = self.pose.lever * angle
        return (torch.hypot(distance, turn) - self.tolerance).clamp(min=0.0)
