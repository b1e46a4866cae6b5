"""The arm's eye: images become keypoints before a control step."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from aicon_torch.errors import ObservationError, choices
from aicon_torch.models.arm_push.image_registration import ImageRegistration
from aicon_torch.models.arm_push.image_segmentation import RGBDImage
from aicon_torch.models.arm_push.polygon import Array, Mask
from aicon_torch.parts.chain import Chain
from aicon_torch.parts.joint_product import Transform

KEYPOINTS, BLOB = "z_keypoints", "z_blob"
"""The readings: keypoints, and the middle of what is seen where these are not found."""

SEEN_AGE = "seen_age"
"""The observation's key of their age, s."""

RECENT_JOINTS = "z_joints_recent"
"""The joint angles of the last steps, where they are remembered."""

IMAGES = ("rgb", "depth")

TRUSTED_SCORE = 0.75
"""Score below which a registration is no reading: it may be that of another orientation."""

Row = tuple[int, ...]
"""Where in a batch."""

Shown = tuple[Array | None, Array | None]
"""The corners of the object's top face ``(K, 3)``, or the middle of what is seen ``(3,)``, m."""

Seen = dict[Row, tuple[Shown, float]]
"""What new images have shown, by row, and how old they were, s."""


class CameraPerception:
    """Turns the images of a camera in the hand into keypoints in the camera's frame.

    A new image is registered from the pose that is believed. Without a registration that fits, the
    middle of what is seen of the object is the reading. NaN says that there is none.

    Args:
        registration: Finds the object in an image.
        chain: From the joints to the tool.
        mount: The camera in the tool.
        dt: Control step, s.
    """

    def __init__(
        self, registration: ImageRegistration, chain: Chain, mount: Transform, dt: float
    ) -> None:
        self.registration, self.chain, self.dt = registration, chain, dt
        self.mount = np.vstack((np.array(mount), [0.0, 0.0, 0.0, 1.0]))

    def __call__(
        self,
        observation: Mapping[str, Any],
        values: Mapping[str, Tensor] | None,
        starts: Mask | None,
    ) -> dict[str, Any]:
        """The observation with readings instead of images.

        Args:
            observation: Images ``rgb`` ``(*B, H, W, 3)`` and ``depth`` ``(*B, H, W)`` (m), their
                age ``image_age`` ``(*B, 1)`` (s), joint angles ``q`` ``(*B, n)`` (rad) and
                velocities ``dq`` (rad/s), and whatever else there is.
            values: The quantities of the last step; None at the first.
            starts: Rows ``(*B,)`` that begin anew; None if none does.

        Returns:
            All but the images, with ``z_keypoints`` ``(*B, 3K)`` and ``z_blob`` ``(*B, 3)``, m.

        Raises:
            ObservationError: If an image, its age or the joints are missing, or are of another
                shape, or the colours are no bytes.
        """
        see = self.begin(observation, values, starts)
        return self.readings(None if see is None else see(), observation)

    def begin(
        self,
        observation: Mapping[str, Any],
        values: Mapping[str, Tensor] | None,
        starts: Mask | None,
    ) -> Callable[[], Seen] | None:
        """The reading of the new images, which takes milliseconds; None if there are none."""
        self._check(observation)
        joints = np.asarray(observation["q"])
        age = np.asarray(observation["image_age"])[..., 0]

        # Which images are to be read, and where nothing is known yet.
        forgotten = np.full(joints.shape[:-1], values is None)
        if starts is not None:
            forgotten = forgotten | starts
        new = self._is_new(age, values, forgotten)
        if not new.any():
            return None

        # Each is read on its own, from where the camera was then.
        views: list[tuple[Row, RGBDImage, Array | None, float]] = []
        for row in map(tuple, np.argwhere(new)):
            rgb, depth = (np.asarray(observation[key][row]).copy() for key in IMAGES)  # to keep
            known = None if values is None or forgotten[row] else values
            since = float(age[row])
            at_exposure = self.camera(self._joints_then(observation, known, row, since))
            image = RGBDImage(rgb, depth, at_exposure[:3, :3], at_exposure[:3, 3])
            prior = None
            if known is not None:
                # Where late images are made up for, the pose that was believed at its exposure.
                believed = known.get("x_pose_then", known["x_pose"])
                prior = believed[row].numpy(force=True).copy()
            views.append((row, image, prior, since))

        def see() -> Seen:
            return {row: (self.look(image, prior), since) for row, image, prior, since in views}

        return see

    def _joints_then(
        self,
        observation: Mapping[str, Any],
        values: Mapping[str, Tensor] | None,
        row: Row,
        age: float,
    ) -> Array:
        """The joint angles ``(n,)`` when an image of this age was taken, rad."""
        joints: Array = np.asarray(observation["q"])[row]
        if values is None or RECENT_JOINTS not in values:
            velocities: Array = np.asarray(observation["dq"])[row]
            return joints - velocities * age

        # As they were read then, or as long ago as is remembered.
        back = round(age / self.dt)
        if back == 0:
            return joints
        recent = values[RECENT_JOINTS][row].numpy(force=True).reshape(-1, len(joints))
        then: Array = recent[-min(back, len(recent))]
        return then

    def readings(
        self, seen: Seen | None, observation: Mapping[str, Any], late: int = 0
    ) -> dict[str, Any]:
        """The observation with readings instead of images, in the frame of the camera as it is now.

        Args:
            seen: What new images have shown in the frame of the base, by row; None for none.
            observation: That of this step.
            late: Since how many steps.
        """
        joints = np.asarray(observation["q"])
        batch = joints.shape[:-1]
        keypoints = np.full((*batch, 3 * len(self.registration.corners)), np.nan)
        blob = np.full((*batch, 3), np.nan)
        age = np.zeros((*batch, 1))

        for row, ((corners, middle), then) in (seen or {}).items():
            age[row] = then + late * self.dt

            # The graph takes what was seen for seen from where the camera is now.
            camera = self.camera(joints[row])
            if corners is not None:
                keypoints[row] = _in_frame(camera, corners).ravel()
            elif middle is not None:
                blob[row] = _in_frame(camera, middle)

        rest = {key: value for key, value in observation.items() if key not in IMAGES}
        return rest | {KEYPOINTS: keypoints, BLOB: blob, SEEN_AGE: age}

    def look(self, image: RGBDImage, prior: Array | None) -> Shown:
        """What an image shows in the frame of the base.

        Args:
            image: The image.
            prior: The pose that is expected, (x, y, θ), ``(3,)``, m and rad; None if none is.

        Returns:
            The corners of the object's top face ``(K, 3)``, or else the middle of what is seen of
            it ``(3,)``, or neither, m.
        """
        found = self.registration(image, prior)
        if found is None:
            return None, None

        # It is there, but perhaps turned some other way.
        if found.score < TRUSTED_SCORE:
            return None, np.array([*found.middle, found.height])

        corners = self.registration.placed(found.pose)
        heights = np.full(len(corners), found.height)
        return np.column_stack((corners, heights)), None

    def camera(self, joints: Array) -> Array:
        """Where the camera is with these joint angles ``(n,)``, ``(4, 4)``, m."""
        with torch.no_grad():
            frames = self.chain.frames(torch.as_tensor(joints, dtype=torch.float64))
        tool: Array = frames[-1].numpy()
        camera: Array = tool @ self.mount
        return camera

    def _check(self, observation: Mapping[str, Any]) -> None:
        """Check that an observation has all that is read here, in the shape of the camera."""
        _, _, _, width, height = self.registration.intrinsics
        image, joints = (round(height), round(width)), (len(self.chain.names),)
        shapes = {"rgb": (*image, 3), "depth": image, "image_age": (1,), "q": joints, "dq": joints}
        for key in shapes:
            if key not in observation:
                valid = choices(observation)
                raise ObservationError(f"the observation has no {key!r}; it has {valid}.")

        batch = np.shape(observation["q"])[:-1]
        for key, shape in shapes.items():
            expected, got = (*batch, *shape), tuple(np.shape(observation[key]))
            if got != expected:
                raise ObservationError(f"{key!r}: expected shape {expected}, got {got}.")

        dtype = np.asarray(observation["rgb"]).dtype
        if dtype != np.uint8:
            raise ObservationError(f"'rgb': expected uint8, 0 to 255, got {dtype}.")

    @staticmethod
    def _is_new(age: NDArray[Any], values: Mapping[str, Tensor] | None, forgotten: Mask) -> Mask:
        """Which images ``(*B,)`` are new: one that was read before is older than it was then."""
        # What is of age zero was taken in this very step.
        new: Mask = forgotten | (age <= 0)
        if values is not None:
            new |= age < values["z_age"].numpy(force=True)[..., 0]
        return new


def _in_frame(frame: Array, points: Array) -> Array:
    """Points ``(*N, 3)`` of the base in a frame ``(4, 4)``, m."""
    return (points - frame[:3, 3]) @ frame[:3, :3]
