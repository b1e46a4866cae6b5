"""Readings that come late.

Pusher and object are filtered as they were when the reading was taken (y_pusher, y_pose), and moved
on to now (x_pusher, x_pose) by the actions since.
"""

from dataclasses import dataclass
from typing import cast

import torch
from torch import Tensor

from aicon_torch.estimation import Estimator
from aicon_torch.interconnections import Values
from aicon_torch.parts.pose import PoseMotion
from aicon_torch.shaping import straight_through


class ActionHistory(Estimator):
    """a_past: the last actions of a pusher in the plane, oldest first, ``(*B, 2·steps)``, m/s.

    Args:
        steps: How many.
    """

    outputs = ("a_past",)
    inputs = ("a_past", "a")

    def __init__(self, steps: int) -> None:
        super().__init__()
        self.register_buffer("at_rest", torch.zeros(2 * steps))

    def initial(self, values: Values) -> dict[str, Tensor]:
        """The pusher was at rest."""
        return {"a_past": cast(Tensor, self.at_rest)}

    def update(self, values: Values) -> dict[str, Tensor]:
        """The oldest action goes, the last one comes."""
        past, last = cast(Tensor, values["a_past"]), cast(Tensor, values["a"])
        return {"a_past": torch.cat((past[..., 2:], last), dim=-1)}

    def forward(self, values: Values, output: str) -> Tensor:
        """The same actions: what is past depends on nothing."""
        return cast(Tensor, values["a_past"]).detach()  # no gradient reaches the past


def delayed_position(y_pusher: Tensor, a_past: Tensor, dt: float) -> Tensor:
    """y_pusher: where the pusher was when the reading was taken, moved by the oldest action.

    Args:
        y_pusher: Where it was one step before, ``(*B, 2)``, m.
        a_past: The actions since, ``(*B, 2·steps)``, m/s.
        dt: Time step, s.

    Returns:
        ``(*B, 2)``, m.
    """
    return y_pusher + a_past[..., :2].detach() * dt  # no gradient reaches the past


def current_position(y_pusher: Tensor, a_past: Tensor, a: Tensor, dt: float) -> Tensor:
    """x_pusher: where the actions since the reading have brought the pusher.

    Args:
        y_pusher: Where it was when the reading was taken, ``(*B, 2)``, m.
        a_past: The actions since, after the oldest, ``(*B, 2·steps)``, m/s.
        a: The next action, which moves it by a·dt, ``(*B, 2)``, m/s.
        dt: Time step, s.

    Returns:
        ``(*B, 2)``, m.
    """
    velocities = a_past[..., 2:].reshape(*y_pusher.shape[:-1], -1, 2)
    since = velocities.sum(-2).detach() * dt  # no gradient reaches the past
    return straight_through(y_pusher + since, a * dt)


@dataclass(frozen=True)
class DelayedPoseMotion:
    """y_pose: the object's pose when the reading was taken, moved by the oldest action.

    Attributes:
        motion: How the pusher moves the object.
    """

    motion: PoseMotion

    def __call__(self, y_pose: Tensor, y_pusher: Tensor, a_past: Tensor, dt: float) -> Tensor:
        """The pose.

        Args:
            y_pose: The pose one step before, ``(*B, 3)``, m and rad.
            y_pusher: Where the pusher was when the reading was taken, ``(*B, 2)``, m.
            a_past: The actions since, ``(*B, 2·steps)``, m/s.
            dt: Time step, s.

        Returns:
            ``(*B, 3)``, m and rad.
        """
        return self.motion(y_pose, y_pusher, a_past[..., :2], dt)


@dataclass(frozen=True)
class CurrentPose:
    """x_pose: the pose to which the actions since the reading have brought the object.

    Attributes:
        motion: How the pusher moves the object.
    """

    motion: PoseMotion

    def __call__(self, y_pose: Tensor, y_pusher: Tensor, a_past: Tensor, dt: float) -> Tensor:
        """The pose ``(*B, 3)``, m and rad.

        Args:
            y_pose: The pose when the reading was taken, ``(*B, 3)``, m and rad.
            y_pusher: Where the pusher was then, ``(*B, 2)``, m.
            a_past: The actions since, after the oldest, ``(*B, 2·steps)``, m/s.
            dt: Time step, s.
        """
        pose, pusher = y_pose.detach(), y_pusher.detach()  # what was done since is past
        for start in range(2, a_past.shape[-1], 2):
            action = a_past[..., start : start + 2]
            pusher = pusher + action.detach() * dt  # likewise
            pose = self.motion(pose, pusher, action, dt)
        return pose
