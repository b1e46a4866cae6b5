"""A policy with an eye: images become keypoints before a control step, all else is the library's."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import torch
from numpy.typing import ArrayLike
from torch import Tensor

from aicon_torch.control import ActionLaw
from aicon_torch.errors import ObservationError
from aicon_torch.graph import WorldModel
from aicon_torch.parts.chain import Kinematics
from aicon_torch.parts.image_registration import Array, Registration, View
from aicon_torch.models.panda_push.robot import Robot
from aicon_torch.control import Policy
from aicon_torch.resolution import Memory, Resolution

KEYPOINTS, BLOB, AGE = "z_keypoints", "z_blob", "image_age"


class SeeingPolicy(Policy):
    """A policy whose observations have images ``rgb`` and ``depth``, with their age, in place of keypoints.

    A new image is registered from the pose that the memory expects; without a registration that fits, the middle of
    what is seen of the object is the reading. All that lives from step to step is in the memory still.

    Args:
        model: The world model.
        resolution: What happens where gradients meet.
        law: From the gradient to the action.
        registration: Finds the object in an image.
        kinematics: The chain.
        robot: The robot.
        scale: px of the contact model per m.
        trust: Score below which a registration is no reading.
    """

    def __init__(
        self,
        model: WorldModel,
        resolution: Resolution,
        law: ActionLaw,
        registration: Registration,
        kinematics: Kinematics,
        robot: Robot,
        scale: float,
        trust: float,
    ) -> None:
        super().__init__(model, resolution, law)
        self.registration, self.kinematics = registration, kinematics
        self.mount = np.vstack((np.array(robot.camera), [0.0, 0.0, 0.0, 1.0]))
        self.scale, self.trust = scale, trust

    def _begin(
        self, observation: Mapping[str, Any], state: Memory | None, episode_start: ArrayLike | Tensor | None
    ) -> tuple[Memory, dict[str, Tensor]]:
        return super()._begin(self.read(observation, state, episode_start), state, episode_start)

    def read(
        self, observation: Mapping[str, Any], state: Memory | None, episode_start: ArrayLike | Tensor | None = None
    ) -> dict[str, Any]:
        """The observation with keypoints, or the middle of what is seen, instead of images; NaN where there are none.

        Args:
            observation: As for :meth:`predict`, with ``rgb``, ``depth``, ``image_age``, ``q`` and ``dq``.
            state: The memory that the last step returned.
            episode_start: Rows whose memory starts anew.

        Raises:
            ObservationError: If an image is missing.
        """
        for key in ("rgb", "depth", AGE, "q", "dq"):
            if key not in observation:
                raise ObservationError(f"the observation has no {key!r}; it has {', '.join(map(repr, observation))}.")
        rgb, depth, age, joints, speeds = (np.asarray(observation[key]) for key in ("rgb", "depth", AGE, "q", "dq"))
        batch = joints.shape[:-1]
        count = len(self.registration.corners)
        keypoints, blob = np.full((*batch, count * 3), np.nan), np.full((*batch, 3), np.nan)
        forget = state is None if episode_start is None else np.asarray(episode_start, dtype=bool) | (state is None)
        fresh = np.broadcast_to(forget, batch)
        before, belief = (
            np.zeros((*batch, size)) if state is None else state[name].numpy(force=True)
            for name, size in (("z_age", 1), ("x_pose", 3))
        )
        for row in np.ndindex(batch):
            if not fresh[row] and age[row][0] > 0 and age[row][0] >= before[row][0]:
                continue  # the image is that of the last step
            taken = self.camera(joints[row] - speeds[row] * age[row][0])
            view = View(rgb[row], depth[row], taken[:3, :3], taken[:3, 3])
            prior = None if fresh[row] else belief[row] / (self.scale, self.scale, 1.0)
            points, middle = self.look(view, prior)
            here = self.camera(joints[row])
            if points is not None:
                keypoints[row] = ((points - here[:3, 3]) @ here[:3, :3]).ravel()
            elif middle is not None:
                blob[row] = (middle - here[:3, 3]) @ here[:3, :3]
        rest = {key: value for key, value in observation.items() if key not in ("rgb", "depth")}
        return rest | {KEYPOINTS: keypoints, BLOB: blob}

    def look(self, view: View, prior: Array | None) -> tuple[Array | None, Array | None]:
        """The corners of the top face ``(N, 3)``, or else the middle of what is seen of it ``(3,)``, m."""
        sight = self.registration(view, prior)
        if sight is None:
            return None, None
        if sight.score < self.trust:
            return None, np.array([*sight.middle, sight.top])
        corners = self.registration.placed(sight.pose)
        return np.column_stack((corners, np.full(len(corners), sight.top))), None

    def camera(self, joints: Array) -> Array:
        """Where the camera is with these joint angles, ``(4, 4)``."""
        with torch.no_grad():
            frames = self.kinematics.frames(torch.as_tensor(joints, dtype=torch.float64))
        found: Array = frames[7].numpy() @ self.mount
        return found
