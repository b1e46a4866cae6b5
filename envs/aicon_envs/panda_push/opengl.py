"""Chooses how to render without a display, before MuJoCo is imported: MuJoCo reads `MUJOCO_GL` only then."""

import ctypes.util
import os

HELP = (
    "Without a display it needs, on Debian, libegl1 libegl-mesa0 libgl1-mesa-dri, or libosmesa6 and MUJOCO_GL=osmesa; "
    "`import aicon_envs.panda_push` before `import mujoco`, which reads MUJOCO_GL, chooses between them."
)

BACKENDS = {"egl": "EGL", "osmesa": "OSMesa"}
"""The backends of MuJoCo that need no display and the library of each, the first choice first."""


def choose() -> None:
    """Set `MUJOCO_GL` to the first backend whose library is there, unless it is set or there is a display."""
    if "MUJOCO_GL" in os.environ or os.environ.get("DISPLAY"):
        return
    for backend, library in BACKENDS.items():
        if ctypes.util.find_library(library):
            os.environ["MUJOCO_GL"] = backend
            return


def load() -> None:
    """Choose, and import MuJoCo.

    Raises:
        RuntimeError: If `MUJOCO_GL` names a backend whose library is missing; it names the packages.
    """
    choose()
    try:
        import mujoco  # noqa: F401
    except AttributeError as error:  # PyOpenGL's way to say that there is no library
        raise RuntimeError(
            f"MuJoCo cannot be loaded with MUJOCO_GL={os.environ.get('MUJOCO_GL')}: {error}. {HELP}"
        ) from error


load()
