"""Readings that come late.

Pusher and object are filtered as they were when the reading was taken (y_pusher, y_pose), and moved
on to now (x_pusher, x_pose) by the motions since.
"""

from dataclasses import dataclass
from typing import cast

import torch
from torch import Tensor

from aicon_torch.estimation import Estimator
from aicon_torch.interconnections import Values
from aicon_torch.parts.pose import PoseMotion
from aicon_torch.shaping import straight_through


class MotionHistory(Estimator):
    """d_past: a pusher's way through each of its last steps, oldest first, ``(*B, 2n·steps)``, m.

    Args:
        steps: How many.
        parts: Number n of the parts of a step, as in d_pusher.
    """

    outputs = ("d_past",)
    inputs = ("d_past", "d_pusher")

    def __init__(self, steps: int, parts: int) -> None:
        super().__init__()
        self.register_buffer("at_rest", torch.zeros(steps * 2 * parts))

    def initial(self, values: Values) -> dict[str, Tensor]:
        """The pusher was at rest."""
        return {"d_past": cast(Tensor, self.at_rest)}

    @torch.no_grad()
    def update(self, values: Values) -> dict[str, Tensor]:
        """The oldest step goes, the last one comes."""
        return {"d_past": self(values, "d_past")}

    def forward(self, values: Values, output: str) -> Tensor:
        """Likewise, with the step to come."""
        past, last = cast(Tensor, values["d_past"]), cast(Tensor, values["d_pusher"])
        kept = past[..., last.shape[-1] :]
        return torch.cat((kept, last), dim=-1).detach()  # no gradient reaches the past


def delayed_position(y_pusher: Tensor, d_past: Tensor, d_pusher: Tensor) -> Tensor:
    """y_pusher: where the pusher was when the reading was taken, moved by the oldest step.

    Args:
        y_pusher: Where it was one step before, ``(*B, 2)``, m.
        d_past: Its ways since, ``(*B, 2n·steps)``, m.
        d_pusher: Its way through the last step, which tells n, ``(*B, 2n)``, m.

    Returns:
        ``(*B, 2)``, m.
    """
    oldest = _ways(d_past, d_pusher)[..., 0, -1, :]
    return y_pusher + oldest.detach()  # no gradient reaches the past


def current_position(
    y_pusher: Tensor, d_past: Tensor, d_pusher: Tensor, a: Tensor, dt: float
) -> Tensor:
    """x_pusher: where the steps since the reading have brought the pusher.

    Args:
        y_pusher: Where it was when the reading was taken, ``(*B, 2)``, m.
        d_past: Its ways since, after the oldest step, ``(*B, 2n·steps)``, m.
        d_pusher: Its way through the last step, which tells n, ``(*B, 2n)``, m.
        a: The next action, which moves it by a·dt, ``(*B, 2)``, m/s.
        dt: Time step, s.

    Returns:
        ``(*B, 2)``, m.
    """
    since = _ways(d_past, d_pusher)[..., 1:, -1, :].sum(-2)
    return straight_through(y_pusher + since.detach(), a * dt)  # no gradient reaches the past


@dataclass(frozen=True)
class DelayedPoseMotion:
    """y_pose: the object's pose when the reading was taken, moved by the oldest step.

    Attributes:
        motion: How the pusher moves the object.
    """

    motion: PoseMotion

    def __call__(
        self, y_pose: Tensor, y_pusher: Tensor, d_past: Tensor, d_pusher: Tensor
    ) -> Tensor:
        """The pose ``(*B, 3)``, m and rad.

        Args:
            y_pose: The pose one step before, ``(*B, 3)``, m and rad.
            y_pusher: Where the pusher was when the reading was taken, ``(*B, 2)``, m.
            d_past: Its ways since, ``(*B, 2n·steps)``, m.
            d_pusher: Its way through the last step, which tells n, ``(*B, 2n)``, m.
        """
        oldest = _ways(d_past, d_pusher)[..., 0, :, :]
        return self.motion(y_pose, y_pusher, oldest.flatten(-2))


@dataclass(frozen=True)
class CurrentPose:
    """x_pose: the pose to which the steps since the reading have brought the object.

    Attributes:
        motion: How the pusher moves the object.
    """

    motion: PoseMotion

    def __call__(
        self, y_pose: Tensor, y_pusher: Tensor, d_past: Tensor, d_pusher: Tensor
    ) -> Tensor:
        """The pose ``(*B, 3)``, m and rad.

        Args:
            y_pose: The pose when the reading was taken, ``(*B, 3)``, m and rad.
            y_pusher: Where the pusher was then, ``(*B, 2)``, m.
            d_past: Its ways since, after the oldest step, ``(*B, 2n·steps)``, m.
            d_pusher: Its way through the last step, which tells n, ``(*B, 2n)``, m.
        """
        pose, pusher = y_pose.detach(), y_pusher.detach()  # what was done since is past
        ways = _ways(d_past, d_pusher).detach()  # likewise

        for way in ways[..., 1:, :, :].unbind(-3):
            pusher = pusher + way[..., -1, :]
            pose = self.motion(pose, pusher, way.flatten(-2))
        return pose


def _ways(d_past: Tensor, d_pusher: Tensor) -> Tensor:
    """The ways through the last steps, oldest first, ``(*B, steps, n, 2)``, m."""
    parts = d_pusher.shape[-1] // 2
    return d_past.reshape(*d_past.shape[:-1], -1, parts, 2)
