"""The images that the camera in the hand delivers: at 20 Hz, noisy, and late."""

from typing import NamedTuple

import mujoco
import numpy as np

from aicon_envs.arm_push.rendering import Camera, ColorImage, DepthImage
from aicon_envs.arm_push.spaces import MAX_DEPTH

INTERVAL = 5
"""Control steps between images."""


class HandImage(NamedTuple):
    """An image, and when it was taken.

    Attributes:
        step: Control step in which it was taken.
        color: ``(height, width, 3)``.
        depth: Distance along the optical axis, ``(height, width)``, m.
    """

    step: int
    color: ColorImage
    depth: DepthImage


class HandCamera:
    """A camera whose images arrive after a delay.

    Args:
        delay: Control steps from when an image is taken to when it arrives.
        depth_noise: Standard deviation of the noise on the depth, m.
    """

    def __init__(self, delay: int, depth_noise: float) -> None:
        """Prepare a camera that has taken no image."""
        self._delay = delay
        self._depth_noise = depth_noise
        self._images: list[HandImage] = []

    def restart(self) -> None:
        """Forget the images of the last episode."""
        self._images.clear()

    def is_due(self, step: int) -> bool:
        """Whether an image is to be taken in a control step."""
        return step % INTERVAL == 0

    def take(
        self, camera: Camera, data: mujoco.MjData, step: int, generator: np.random.Generator
    ) -> None:
        """Take an image of a state."""
        color, depth = camera(data)
        depth += generator.normal(0.0, self._depth_noise, depth.shape).astype(np.float32)
        self._images.append(HandImage(step, color, depth.clip(0.0, MAX_DEPTH)))

    def latest(self, step: int) -> HandImage:
        """Return the newest image that has arrived; before any has, the first."""
        arrived_until = step - self._delay
        while len(self._images) > 1 and self._images[1].step <= arrived_until:
            self._images.pop(0)

        return self._images[0]
