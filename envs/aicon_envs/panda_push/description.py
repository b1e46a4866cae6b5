"""The robot as plain data, read off the compiled model: what a policy may know of its own body."""

import math
from typing import Any
from xml.etree import ElementTree

import mujoco
import numpy as np
from numpy.typing import NDArray

from aicon_envs.panda_push import scene

Capsule = tuple[int, tuple[float, float, float], tuple[float, float, float], float]
"""Link (0 is the base, 8 the tool), both ends in its frame (m), radius (m)."""


def describe(model: mujoco.MjModel, width: int, height: int) -> dict[str, Any]:
    """The robot's geometry.

    Args:
        model: The compiled scene.
        width: Width of the camera's image, px.
        height: Its height, px.

    Returns:
        ``frames``: for each joint the fixed transform ``(4, 4)`` from the previous link, after which it turns about z;
        ``tool``: that of the tool in the last link; ``camera``: that of the camera in the tool, with z into the image,
        x to its right and y down; ``intrinsics``: f, cₓ, c_y, width and height, px; ``low``, ``high``: joint limits,
        rad; ``speed``: rad/s; ``capsules``: see :data:`Capsule`; ``stick_length``, ``stick_radius``: m; ``tool_mass``:
        kg.
    """
    frames = [_transform(model, f"panda_link{index}") for index in range(1, 8)]
    tool = _transform(model, "panda_link8") @ _transform(model, "tool")
    camera = np.eye(4)
    number = model.camera("hand").id
    camera[:3, :3] = _matrix(model.cam_quat[number]) @ np.diag([1.0, -1.0, -1.0])
    camera[:3, 3] = model.cam_pos[number]
    focal = height / 2 / math.tan(math.radians(model.cam_fovy[number]) / 2)
    limits = np.array([model.joint(name).range for name in scene.JOINTS])
    return {
        "frames": tuple(map(_rows, frames)),
        "tool": _rows(tool),
        "camera": _rows(camera),
        "intrinsics": (focal, (width - 1) / 2, (height - 1) / 2, float(width), float(height)),
        "low": tuple(limits[:, 0].tolist()),
        "high": tuple(limits[:, 1].tolist()),
        "speed": scene.SPEED_LIMIT,
        "capsules": tuple(capsules()),
        "stick_length": scene.STICK_LENGTH,
        "stick_radius": scene.STICK_RADIUS,
        "tool_mass": scene.TOOL_MASS,
    }


def capsules() -> list[Capsule]:
    """The capsules of the arm's collision description, and those of the tool."""
    root = ElementTree.fromstring(
        (scene._description_folder() / "urdf" / "panda_collision.urdf").read_text()
    )
    found: list[Capsule] = []
    for link in root.findall("link"):
        name = str(link.get("name"))
        if not name.removeprefix("panda_link").isdigit() or name == "panda_link8":
            continue
        for collision in link.findall("collision"):
            cylinder = collision.find("geometry/cylinder")
            if cylinder is None:
                continue  # the spheres are the ends of the cylinders
            origin = collision.find("origin")
            turn = _numbers(None if origin is None else origin.get("rpy"))
            middle = _numbers(None if origin is None else origin.get("xyz"))
            axis = _euler(*turn)[:, 2] * float(str(cylinder.get("length"))) / 2
            radius = float(str(cylinder.get("radius")))
            found.append((int(name[-1]), _point(middle - axis), _point(middle + axis), radius))
    found.append(
        (
            8,
            (0.0, 0.0, 0.0),
            (0.0, 0.0, scene.STICK_LENGTH - scene.STICK_RADIUS),
            scene.STICK_RADIUS,
        )
    )
    found.append((8, (scene.CAMERA[0], -0.015, 0.01), (scene.CAMERA[0], 0.015, 0.01), 0.025))
    return found


def _point(values: NDArray[np.float64]) -> tuple[float, float, float]:
    x, y, z = values.tolist()
    return x, y, z


def _transform(model: mujoco.MjModel, body: str) -> NDArray[np.float64]:
    transform = np.eye(4)
    transform[:3, :3] = _matrix(model.body(body).quat)
    transform[:3, 3] = model.body(body).pos
    return transform


def _matrix(quaternion: NDArray[np.float64]) -> NDArray[np.float64]:
    matrix = np.zeros(9)
    mujoco.mju_quat2Mat(matrix, quaternion)
    return matrix.reshape(3, 3)


def _euler(roll: float, pitch: float, yaw: float) -> NDArray[np.float64]:
    quaternion = np.zeros(4)
    mujoco.mju_euler2Quat(
        quaternion, np.array([roll, pitch, yaw]), "XYZ"
    )  # about the fixed axes, as URDF has it
    return _matrix(quaternion)


def _numbers(text: str | None) -> NDArray[np.float64]:
    return np.array([float(number) for number in (text or "0 0 0").split()])


def _rows(matrix: NDArray[np.float64]) -> tuple[tuple[float, ...], ...]:
    return tuple(tuple(row) for row in matrix.tolist())
