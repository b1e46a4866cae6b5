"""Model-predictive path integral control of pushT, to be timed beside AICON: pytorch-mppi."""

from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from aicon_torch.models.pusht import PIXEL, Options, rigid_object
from aicon_torch.models.pusht.benchmark import PUSHER_RADIUS
from aicon_torch.parts.planar import norm, pose_error
from aicon_torch.parts.pose import PoseMotion
from aicon_torch.parts.servo import Servo

DT = 0.1  # s, a control step of pushT


class Mppi:
    """MPPI with AICON's contact model, on the same readings.

    It samples velocities, predicts the object with `PoseMotion`, and weighs samples by pose error
    and distance.
    """

    def __init__(self, samples: int = 256, horizon: int = 16, seed: int = 0) -> None:
        """Prepare the model; the samples are drawn from a generator with this seed."""
        from pytorch_mppi import MPPI

        torch.manual_seed(seed)
        options = Options()
        self._body, self._servo = rigid_object(options), Servo.of()
        self._motion = PoseMotion(options.contact.dynamics(self._body), PUSHER_RADIUS)
        goal = torch.tensor(options.goal_pose, dtype=torch.float64)
        self._goal = self._body.pose_of_frame(goal)

        speed = torch.full((2,), 400.0 * PIXEL, dtype=torch.float64)
        self._mppi = MPPI(
            self._dynamics,
            self._cost,
            nx=5,
            noise_sigma=torch.eye(2, dtype=torch.float64) * (300.0 * PIXEL) ** 2,
            num_samples=samples,
            horizon=horizon,
            lambda_=0.005,
            u_min=-speed,
            u_max=speed,
        )

    def predict(
        self,
        observation: dict[str, Any],
        state: Tensor | None = None,
        episode_start: NDArray[np.bool_] | None = None,
        deterministic: bool = True,
    ) -> tuple[NDArray[np.float64], Tensor]:
        """The next position target (2,), px, and where the pusher is, m."""
        keypoints = _metres(observation["environment_state"]).reshape(-1, 2)
        pusher = _metres(observation["agent_pos"])
        velocity = torch.zeros_like(pusher) if state is None else (pusher - state) / DT

        pose = self._body.registration(keypoints)
        action = self._mppi.command(torch.cat((pose, pusher)))
        target = pusher + self._servo.target_offset(action, velocity, DT)
        return (target / PIXEL).numpy(), pusher

    def _dynamics(self, state: Tensor, action: Tensor) -> Tensor:
        moved = DT * action
        pusher = state[..., 3:] + moved
        return torch.cat((self._motion(state[..., :3], pusher, moved), pusher), dim=-1)

    def _cost(self, state: Tensor, action: Tensor) -> Tensor:
        """Pose error, and a tenth of what the pusher is farther than 6 cm away, m."""
        away = (norm(state[..., 3:] - state[..., :2]) - 60.0 * PIXEL).clamp(min=0.0)
        error = pose_error(state[..., :3], self._goal, self._body.radius_of_gyration)
        return norm(error) + 0.1 * away


def _metres(reading: Any) -> Tensor:
    return PIXEL * torch.as_tensor(reading, dtype=torch.float64)
