"""What the planner predicts: where pusher and object are after a step, by AICON's own model."""

import torch
from torch import Tensor

from aicon_torch.models.pusht import Options, rigid_object
from aicon_torch.models.pusht.benchmark import PUSHER_RADIUS, SUBSTEP, WORKSPACE
from aicon_torch.parts.pose import PoseMotion
from aicon_torch.parts.servo import Servo

STATE_SIZE = 7
"""Pose of the object (x, y, θ), position and velocity of the pusher; m, rad and m/s."""

_PART = 2  # sub-steps of the servo in a part of the pusher's way


class Prediction:
    """The state after a step in which the servo gives the pusher a mean velocity.

    The pusher goes as the servo moves it, :class:`aicon_torch.parts.servo.Servo`, to a target
    within the board. The object is pushed as :class:`aicon_torch.parts.pose.PoseMotion` says, part
    by part of this way: in one part, a fast pusher would jump over the object.

    Args:
        options: Those of AICON's model.
    """

    def __init__(self, options: Options) -> None:
        self.dt = options.dt
        self.body = rigid_object(options)
        self.servo = Servo.of(substep=SUBSTEP, substeps=options.substeps)
        self.dynamics = options.contact.dynamics(self.body)
        self._motion = PoseMotion(self.dynamics, PUSHER_RADIUS)

    def __call__(self, state: Tensor, velocity: Tensor) -> Tensor:
        """The state (*B, 7) after a step with a mean velocity (*B, 2), m/s."""
        pose, pusher, speed = torch.split(state, [3, 2, 2], dim=-1)

        # The target that yields this velocity, as far as the board goes.
        offset = self.servo.target_offset(velocity, speed, self.dt)
        offset = (pusher + offset).clamp(*WORKSPACE) - pusher

        # The pusher's way, what it does to the object, and how the pusher arrives.
        way = self._way(offset, speed)
        pose = self._push(pose, pusher, way)
        speed = self.servo.velocity_by_offset * offset + self.servo.velocity_by_velocity * speed
        return torch.cat((pose, pusher + way[-1], speed), dim=-1)

    def _way(self, offset: Tensor, speed: Tensor) -> list[Tensor]:
        """How far the pusher is displaced after each part of a step, (*B, 2), m."""
        by_offset = self.servo.displacement_by_offset
        by_speed = self.servo.displacement_by_velocity

        last = len(by_offset) - 1
        indices = sorted({*range(_PART - 1, last, _PART), last})
        return [by_offset[index] * offset + by_speed[index] * speed for index in indices]

    def _push(self, pose: Tensor, pusher: Tensor, way: list[Tensor]) -> Tensor:
        """The object's pose (*B, 3) after the pusher (*B, 2) went this way."""
        return self._motion(pose, pusher + way[-1], torch.cat(way, dim=-1))
