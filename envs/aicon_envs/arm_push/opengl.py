"""Chooses how to render without a display, before MuJoCo is imported: MuJoCo reads it only then."""

import ctypes.util
import os
import sys
import warnings

from gymnasium.error import DependencyNotInstalled

HELP = (
    "Without a display it needs, on Debian, libegl1 libegl-mesa0 libgl1-mesa-dri, or libosmesa6 "
    "and MUJOCO_GL=osmesa; `import aicon_envs.arm_push` before `import mujoco`, which reads "
    "MUJOCO_GL, chooses between them."
)

BACKENDS = {"egl": "EGL", "osmesa": "OSMesa"}
"""MuJoCo's backends that need no display and the library of each, the first choice first."""


def choose_backend() -> None:
    """Set `MUJOCO_GL` to the first backend whose library is there.

    Does nothing if it is set, or if there is a display.
    """
    if "MUJOCO_GL" in os.environ or os.environ.get("DISPLAY"):
        return

    for backend, library in BACKENDS.items():
        if ctypes.util.find_library(library):
            os.environ["MUJOCO_GL"] = backend
            return


def import_mujoco() -> None:
    """Choose a backend, and import MuJoCo.

    Raises:
        DependencyNotInstalled: If MuJoCo is not there; it says how to install it.
        RuntimeError: If `MUJOCO_GL` names a backend whose library is missing; it names the
            packages.
    """
    choose_backend()

    try:
        import mujoco  # noqa: F401
    except ModuleNotFoundError as error:
        raise DependencyNotInstalled(
            'an arm needs MuJoCo: pip install "aicon-torch[panda]", or, for the task reach, '
            '"aicon-torch[reach]"'
        ) from error
    except AttributeError as error:  # PyOpenGL's way to say that there is no library
        backend = os.environ.get("MUJOCO_GL")
        raise RuntimeError(
            f"MuJoCo cannot be loaded with MUJOCO_GL={backend}: {error}. {HELP}"
        ) from error


def check_display() -> None:
    """Check that a window can be opened, if MuJoCo is about to open one.

    It does where `MUJOCO_GL` names no other backend, and without a display it may end the process.

    Raises:
        RuntimeError: If there is no display; it names the packages that need none.
    """
    if sys.platform != "linux" or os.environ.get("MUJOCO_GL", "") not in ("", "glfw"):
        return

    import glfw  # with which MuJoCo opens windows

    with warnings.catch_warnings(action="ignore"):  # its way to say why not
        has_display = glfw.init()
    if not has_display:
        raise RuntimeError(f"MuJoCo cannot render: there is no display. {HELP}")


import_mujoco()
