"""The robot as plain data, read off the compiled model: what a policy may know of its own body."""

import math
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from aicon_envs.panda_push import robot
from aicon_envs.panda_push.capsules import robot_capsules

FloatArray = NDArray[np.float64]


def describe(model: mujoco.MjModel, width: int, height: int) -> dict[str, Any]:
    """Return the robot's geometry.

    Args:
        model: The compiled scene.
        width: Width of the camera's image, px.
        height: Its height, px.

    Returns:
        ``frames``: for each joint the fixed transform ``(4, 4)`` from the previous link, after
        which it turns about z; ``tool``: that of the tool in the last link; ``camera``: that of the
        camera in the tool, with z into the image, x to its right and y down; ``intrinsics``: f, cₓ,
        c_y, width and height, px; ``low``, ``high``: joint limits, rad; ``speed``: rad/s;
        ``capsules``: see :data:`aicon_envs.panda_push.capsules.Capsule`; ``stick_length``,
        ``stick_radius``: m; ``tool_mass``: kg.
    """
    frames = [_body_transform(model, f"panda_link{index}") for index in range(1, 8)]
    tool = _body_transform(model, "panda_link8") @ _body_transform(model, "tool")
    camera = _camera_transform(model, "hand")
    limits = np.array([model.joint(name).range for name in robot.JOINTS])

    return {
        "frames": tuple(_to_rows(frame) for frame in frames),
        "tool": _to_rows(tool),
        "camera": _to_rows(camera),
        "intrinsics": _intrinsics(model, "hand", width, height),
        "low": tuple(limits[:, 0].tolist()),
        "high": tuple(limits[:, 1].tolist()),
        "speed": robot.SPEED_LIMIT,
        "capsules": tuple(robot_capsules()),
        "stick_length": robot.STICK_LENGTH,
        "stick_radius": robot.STICK_RADIUS,
        "tool_mass": robot.TOOL_MASS,
    }


def _body_transform(model: mujoco.MjModel, name: str) -> FloatArray:
    """Return the transform ``(4, 4)`` of a body in its parent."""
    body = model.body(name)
    transform = np.eye(4)
    transform[:3, :3] = _to_matrix(body.quat)
    transform[:3, 3] = body.pos
    return transform


def _camera_transform(model: mujoco.MjModel, name: str) -> FloatArray:
    """Return the transform ``(4, 4)`` of a camera in its body, z into the image and y down."""
    number = model.camera(name).id
    from_mujoco = np.diag([1.0, -1.0, -1.0])  # whose cameras look along -z with y up

    transform = np.eye(4)
    transform[:3, :3] = _to_matrix(model.cam_quat[number]) @ from_mujoco
    transform[:3, 3] = model.cam_pos[number]
    return transform


def _intrinsics(
    model: mujoco.MjModel, name: str, width: int, height: int
) -> tuple[float, float, float, float, float]:
    """Return f, cₓ, c_y, width and height of a camera's image, px."""
    field_of_view = math.radians(model.cam_fovy[model.camera(name).id])
    focal_length = height / 2 / math.tan(field_of_view / 2)
    return focal_length, (width - 1) / 2, (height - 1) / 2, float(width), float(height)


def _to_matrix(quaternion: FloatArray) -> FloatArray:
    matrix = np.zeros(9)
    mujoco.mju_quat2Mat(matrix, quaternion)
    return matrix.reshape(3, 3)


def _to_rows(matrix: FloatArray) -> tuple[tuple[float, ...], ...]:
    return tuple(tuple(row) for row in matrix.tolist())
