"""Pictures without a display: EGL, or OSMesa where there is no EGL."""

import atexit
import os
import weakref
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from aicon_envs.arm_push.opengl import HELP, check_display

ColorImage = NDArray[np.uint8]
DepthImage = NDArray[np.float32]


_MOST_SHAPES = 10_000
"""That a picture shows; MuJoCo leaves the others out."""


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
        self,
        model: mujoco.MjModel,
        name: str,
        width: int,
        height: int,
        shows: tuple[int, ...] = (),
    ) -> None:
        """Choose what is seen, and open a context to render in."""
        self._model = model
        self._camera = mujoco.MjvCamera()
        self._camera.type = mujoco.mjtCamera.mjCAMERA_FIXED
        self._camera.fixedcamid = model.camera(name).id

        self._option = mujoco.MjvOption()
        self._option.geomgroup[list(shows)] = 1

        self._scene = mujoco.MjvScene(model, maxgeom=_MOST_SHAPES)
        self._scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = 0
        self._scene.flags[mujoco.mjtRndFlag.mjRND_REFLECTION] = 0

        # Where MuJoCo writes what it reads back.
        self._rectangle = mujoco.MjrRect(0, 0, width, height)
        self._color = np.zeros((height, width, 3), np.uint8)
        self._depth = np.zeros((height, width), np.float32)

        self._open_context(width, height)

    def __call__(self, data: mujoco.MjData) -> tuple[ColorImage, DepthImage]:
        """Return the picture of a state.

        Returns:
            Its color ``(height, width, 3)``, and the distance along the optical axis
            ``(height, width)``, m.
        """
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

        # OpenGL's depth buffer is not linear, and its rows go from the bottom up.
        extent = self._model.stat.extent
        near = self._model.vis.map.znear * extent
        far = self._model.vis.map.zfar * extent
        depth = near / (1.0 - self._depth * (1.0 - near / far))
        return self._color[::-1].copy(), depth[::-1].astype(np.float32)

    def close(self) -> None:
        """Give the context back."""
        self._free()

    def _open_context(self, width: int, height: int) -> None:
        """Open an OpenGL context, and see to it that it is given back."""
        # What is beyond the model's framebuffer would stay black.
        framebuffer = self._model.vis.global_
        framebuffer.offwidth = max(width, framebuffer.offwidth)
        framebuffer.offheight = max(height, framebuffer.offheight)

        check_display()
        try:
            self._gl = mujoco.GLContext(width, height)
            self._gl.make_current()
            self._context = mujoco.MjrContext(self._model, mujoco.mjtFontScale.mjFONTSCALE_100)
        except (ImportError, AttributeError, RuntimeError, mujoco.FatalError) as error:
            # Whatever a driver lacks.
            raise RuntimeError(
                f"MuJoCo cannot render (MUJOCO_GL={os.environ.get('MUJOCO_GL')}: {error}). {HELP}"
            ) from error

        # Registered after MuJoCo's own, so it is called while OpenGL is still there.
        self._free = weakref.finalize(self, _free_context, self._context, self._gl)
        self._free.atexit = False
        atexit.register(self._free)

        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._context)


def _free_context(context: mujoco.MjrContext, gl: Any) -> None:
    gl.make_current()
    context.free()
    gl.free()
