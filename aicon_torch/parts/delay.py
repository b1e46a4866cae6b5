"""Readings that come late: pusher and object are filtered as they were then, and moved on by what was done since."""

from dataclasses import dataclass
from typing import cast

import torch
from torch import Tensor

from aicon_torch.estimation import Estimator
from aicon_torch.interconnections import Values
from aicon_torch.parts.pose import PoseMotion
from aicon_torch.shaping import straight_through


class ActionHistory(Estimator):
    """a_past: the last actions, oldest first, ``(*B, 2·steps)``, px/s.

    Args:
        steps: How many.
    """

    outputs = ("a_past",)
    inputs = ("a_past", "a")

    def __init__(self, steps: int) -> None:
        super().__init__()
        self.register_buffer("rest", torch.zeros(2 * steps))

    def initial(self, values: Values) -> dict[str, Tensor]:
        """The pusher was at rest."""
        return {"a_past": cast(Tensor, self.rest)}

    def update(self, values: Values) -> dict[str, Tensor]:
        """The oldest action goes, the last one comes."""
        past, last = cast(Tensor, values["a_past"]), cast(Tensor, values["a"])
        return {"a_past": torch.cat((past[..., 2:], last), dim=-1)}

    def forward(self, values: Values, output: str) -> Tensor:
        """The same actions: what is past depends on nothing."""
        return cast(Tensor, values["a_past"]).detach()  # no gradient reaches the past


def then(y_pusher: Tensor, a_past: Tensor, dt: float) -> Tensor:
    """y_pusher: where the pusher was when the reading was taken, ``(*B, 2)``, px."""
    return y_pusher + a_past[..., :2].detach() * dt


def now(y_pusher: Tensor, a_past: Tensor, a: Tensor, dt: float) -> Tensor:
    """x_pusher: where the actions since have brought it, ``(*B, 2)``, px; the next action moves it by a·dt."""
    since = a_past[..., 2:].reshape(*y_pusher.shape[:-1], -1, 2).sum(-2).detach() * dt  # past as well
    return straight_through(y_pusher + since, a * dt)


@dataclass(frozen=True)
class LatePoseMotion:
    """y_pose: the object's pose when the reading was taken.

    Attributes:
        motion: How the pusher moves it.
    """

    motion: PoseMotion

    def __call__(self, y_pose: Tensor, y_pusher: Tensor, a_past: Tensor, dt: float) -> Tensor:
        """The pose ``(*B, 3)``."""
        return self.motion(y_pose, y_pusher, a_past[..., :2], dt)


@dataclass(frozen=True)
class PoseNow:
    """x_pose: the pose to which the actions since have brought the object.

    Attributes:
        motion: How the pusher moves it.
    """

    motion: PoseMotion

    def __call__(self, y_pose: Tensor, y_pusher: Tensor, a_past: Tensor, dt: float) -> Tensor:
        """The pose ``(*B, 3)``."""
        pose, pusher = y_pose.detach(), y_pusher.detach()  # what was done since is past
        for start in range(2, a_past.shape[-1], 2):
            action = a_past[..., start : start + 2]
            pusher = pusher + action.detach() * dt
            pose = self.motion(pose, pusher, action, dt)
        return pose
