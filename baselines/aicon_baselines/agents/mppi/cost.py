"""What the planner wants: the object at its goal, and the pusher near the object."""

import torch
from torch import Tensor

from aicon_baselines.agents.mppi.options import Options
from aicon_torch.models.pusht.benchmark import PUSHER_RADIUS
from aicon_torch.parts.contact import closest_point
from aicon_torch.parts.contact_dynamics import ContactDynamics
from aicon_torch.parts.planar import norm, pose_error


class Cost:
    """c = ‖(Δx, Δy, LΔθ)‖ + w max(gap, 0), m, for each step.

    The first is what AICON's goal measures, with the same L, the second how far the pusher is from
    the nearest point of the object.

    Args:
        dynamics: What a push does, with L and the object.
        goal: Pose of the object at its goal, (3,), m and rad.
        options: The weight.
    """

    def __init__(self, dynamics: ContactDynamics, goal: Tensor, options: Options) -> None:
        self._rotation_length = dynamics.rotation_length
        self._body = dynamics.body
        self._goal = goal
        self._gap_weight = goal.new_tensor(options.gap_weight)  # compiled once for all weights

    def __call__(self, state: Tensor, velocity: Tensor) -> Tensor:
        """The cost (*B,), m, of a state (*B, 7); the velocity that led to it costs nothing."""
        pose, pusher, _ = torch.split(state, [3, 2, 2], dim=-1)
        error = norm(pose_error(pose, self._goal, self._rotation_length))

        points = closest_point(
            pusher.unsqueeze(-2), self._body.sides(self._body.keypoints_at(pose))
        )
        gap = norm(points - pusher.unsqueeze(-2)).amin(-1) - PUSHER_RADIUS
        return error + self._gap_weight * gap.clamp(min=0.0)
