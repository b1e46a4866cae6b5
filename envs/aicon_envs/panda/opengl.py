"""Chooses how to render without a display, before MuJoCo is imported: MuJoCo reads `MUJOCO_GL` only then."""

import ctypes.util
import os

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


choose()
