"""Pictures without a display: EGL, or OSMesa where there is no EGL."""

import atexit
import os
import weakref
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from aicon_envs.panda_push.opengl import HELP


class Camera:
    """A camera of the scene.

    Args:
        model: The scene.
        name: Name of the camera.
        width: Width of the picture, px.
        height: Its height, px.
        shows: Groups of shapes that it shows besides the usual ones.

    Raises:
        RuntimeError: If nothing can render; it names the packages that are missing.
    """

    def __init__(
        self, model: mujoco.MjModel, name: str, width: int, height: int, shows: tuple[int, ...] = ()
    ) -> None:
        self.name = name
        self._option, self._camera = mujoco.MjvOption(), mujoco.MjvCamera()
        self._option.geomgroup[list(shows)] = 1
        self._camera.type, self._camera.fixedcamid = (
            mujoco.mjtCamera.mjCAMERA_FIXED,
            model.camera(name).id,
        )
        self._model, self._rectangle = model, mujoco.MjrRect(0, 0, width, height)
        self._scene = mujoco.MjvScene(model, maxgeom=200)
        self._scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = 0
        self._scene.flags[mujoco.mjtRndFlag.mjRND_REFLECTION] = 0
        self._color, self._depth = (
            np.zeros((height, width, 3), np.uint8),
            np.zeros((height, width), np.float32),
        )
        try:
            self._gl = mujoco.GLContext(width, height)
            self._gl.make_current()
            self._context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100)
        except (
            ImportError,
            AttributeError,
            RuntimeError,
            mujoco.FatalError,
        ) as error:  # whatever a driver lacks
            raise RuntimeError(
                f"MuJoCo cannot render (MUJOCO_GL={os.environ.get('MUJOCO_GL')}: {error}). {HELP}"
            ) from error
        self._free = weakref.finalize(self, _free, self._context, self._gl)
        self._free.atexit = False
        atexit.register(
            self._free
        )  # registered after MuJoCo's own, so it is called while OpenGL is still there
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._context)

    def __call__(self, data: mujoco.MjData) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
        """The picture ``(height, width, 3)`` and the distance along the optical axis ``(height, width)``, m."""
        self._gl.make_current()
        mujoco.mjv_updateScene(
            self._model,
            data,
            self._option,
            None,
            self._camera,
            mujoco.mjtCatBit.mjCAT_ALL.value,
            self._scene,
        )
        mujoco.mjr_render(self._rectangle, self._scene, self._context)
        mujoco.mjr_readPixels(self._color, self._depth, self._rectangle, self._context)
        extent = self._model.stat.extent
        near, far = self._model.vis.map.znear * extent, self._model.vis.map.zfar * extent
        depth = near / (1.0 - self._depth * (1.0 - near / far))
        return self._color[::-1].copy(), depth[::-1].astype(np.float32)

    def close(self) -> None:
        """Give the context back."""
        self._free()


def _free(context: mujoco.MjrContext, gl: Any) -> None:
    gl.make_current()
    context.free()
    gl.free()
