"""Pictures without a display: EGL, or OSMesa where there is no EGL."""

import os

import mujoco
import numpy as np
from numpy.typing import NDArray


class Camera:
    """A camera of the scene.

    Args:
        model: The scene.
        name: Name of the camera.
        width: Width of the picture, px.
        height: Its height, px.

    Raises:
        RuntimeError: If nothing can render; it names the packages that are missing.
    """

    def __init__(self, model: mujoco.MjModel, name: str, width: int, height: int) -> None:
        self.name = name
        try:
            self._renderer = mujoco.Renderer(model, height, width)
        except (ImportError, AttributeError, RuntimeError, mujoco.FatalError) as error:  # whatever a driver lacks
            raise RuntimeError(
                f"MuJoCo cannot render (MUJOCO_GL={os.environ.get('MUJOCO_GL', 'not set')}: {error}). Without a display "
                "it needs, on Debian, libegl1 libegl-mesa0 libgl1-mesa-dri, or libosmesa6 and MUJOCO_GL=osmesa. "
                "`import aicon_envs.panda` before `import mujoco`, which reads MUJOCO_GL, chooses between them."
            ) from error
        self._renderer.scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = 0
        self._renderer.scene.flags[mujoco.mjtRndFlag.mjRND_REFLECTION] = 0

    def color(self, data: mujoco.MjData) -> NDArray[np.uint8]:
        """The picture, ``(height, width, 3)``."""
        self._renderer.update_scene(data, self.name)
        picture: NDArray[np.uint8] = self._renderer.render().copy()
        return picture

    def depth(self, data: mujoco.MjData) -> NDArray[np.float32]:
        """Distance along the optical axis, ``(height, width)``, m."""
        self._renderer.enable_depth_rendering()
        try:
            self._renderer.update_scene(data, self.name)
            picture: NDArray[np.float32] = self._renderer.render().copy()
        finally:
            self._renderer.disable_depth_rendering()
        return picture

    def close(self) -> None:
        """Give the context back."""
        self._renderer.close()
