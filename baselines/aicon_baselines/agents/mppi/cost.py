"""What the planner wants: the object at its goal, and the pusher where it can push it there."""

import torch
from torch import Tensor

from aicon_baselines.agents.mppi.options import Options
from aicon_torch.models.pusht.benchmark import PUSHER_RADIUS
from aicon_torch.parts.contact import closest_point
from aicon_torch.parts.contact_dynamics import ContactDynamics
from aicon_torch.parts.planar import norm, pose_error
from aicon_torch.vectors import select


class Cost:
    """c = ‖ε‖ + w_gap max(gap, 0) + w_side ‖ε‖ (1 − cos φ), m, for each step.

    ε = (Δx, Δy, LΔθ) is the pose error that AICON's goal measures, with the same L. The gap is that
    between the pusher and the nearest point of the object. φ is the angle between −ε and the motion
    of the object if the pusher pushed there (:meth:`ContactDynamics.response`, its rotation as a
    length by L).

    Args:
        dynamics: What a push does.
        goal: Pose of the object at its goal, (3,), m and rad.
        options: The weights.
    """

    def __init__(self, dynamics: ContactDynamics, goal: Tensor, options: Options) -> None:
        self._dynamics = dynamics
        self._goal = goal

        # Tensors, so that a compiled cost serves all weights.
        self._gap_weight = goal.new_tensor(options.gap_weight)
        self._side_weight = goal.new_tensor(options.side_weight)

    def __call__(self, state: Tensor, velocity: Tensor) -> Tensor:
        """The cost (*B,), m, of a state (*B, 7); the velocity that led to it costs nothing."""
        pose, pusher, _ = state.split((3, 2, 2), dim=-1)
        error = pose_error(pose, self._goal, self._dynamics.rotation_length)
        distance = norm(error)

        # The nearest point of the object, and the direction to it.
        body = self._dynamics.body
        points = closest_point(pusher.unsqueeze(-2), body.sides(body.keypoints_at(pose)))
        distances = norm(points - pusher.unsqueeze(-2))
        nearest = distances.argmin(-1, keepdim=True)
        point = select(points, nearest)
        reach = distances.gather(-1, nearest)

        # How much of a push there would reduce the error.
        motion = self._motion_by_push(pose, point, (point - pusher) / reach)
        cos = -(motion * error).sum(-1) / (norm(motion) * distance)

        gap = (reach.squeeze(-1) - PUSHER_RADIUS).clamp(min=0.0)
        return distance + self._gap_weight * gap + self._side_weight * distance * (1 - cos)

    def _motion_by_push(self, pose: Tensor, point: Tensor, direction: Tensor) -> Tensor:
        """The object's motion (x, y, Lθ) by each metre of a push, (*B, 3)."""
        response = self._dynamics.response(pose, point.unsqueeze(-2), direction.unsqueeze(-2))
        translation, rotation = response.squeeze(-2).split((2, 1), dim=-1)
        return torch.cat((translation, self._dynamics.rotation_length * rotation), dim=-1)
