"""The robot as plain data, read off the compiled model: what a policy may know of its own body."""

import math
from itertools import pairwise
from typing import Any

import mujoco
import numpy as np

from aicon_envs.arm_push import robot
from aicon_envs.arm_push.capsules import robot_capsules, to_matrix, tool_capsules
from aicon_envs.arm_push.inverse_kinematics import home_of, range_of_tip
from aicon_envs.arm_push.reset import CONTACT_HEIGHT
from aicon_envs.arrays import FloatArray
from aicon_envs.reach.robots import Robot, find_file


def describe(model: mujoco.MjModel, arm: Robot, width: int, height: int) -> dict[str, Any]:
    """Return the robot's geometry.

    Args:
        model: The compiled scene.
        arm: The arm in it.
        width: Width of the camera's image, px.
        height: Its height, px.

    Returns:
        ``frames``: for each of the n joints the fixed transform ``(4, 4)`` from the previous link;
        ``axes``: what the link then turns about, ``(3,)``; ``tool``: the transform of the tool in
        the last link; ``camera``: that of the camera in the tool, with z into the image, x to its
        right and y down; ``intrinsics``: f, cₓ, c_y, width and height, px; ``low``, ``high``: joint
        limits, rad; ``speed``: rad/s; ``capsules``: see
        :data:`aicon_envs.arm_push.capsules.Capsule`; ``stick_length``, ``stick_radius``: m;
        ``tool_mass``: kg; ``reach``, ``nearest``: how far from the axis of the base and how near to
        it the upright stick gets, m; ``collisions``: None, or ``urdf``, ``srdf`` (files, the second
        may be None) and ``tip`` of the arm where ``capsules`` are those of the tool only.
    """
    # Transforms from each moved body to the next, and what is at the last of them.
    count = model.nu
    bodies = [0, *model.jnt_bodyid[:count].tolist(), model.body("tool").id]
    frames = [_transform(model, *pair) for pair in pairwise(bodies)]
    camera = _camera_transform(model, "hand")
    low, high = model.jnt_range[:count].T

    # The body: capsules that are known for this arm, or else the shapes of its description.
    capsules = robot_capsules(arm, model)
    srdf = None if arm.srdf is None else str(find_file(arm.srdf))
    shapes = {"urdf": str(find_file(arm.urdf)), "srdf": srdf, "tip": arm.tip}

    nearest, farthest = range_of_tip(model, home_of(model, arm), CONTACT_HEIGHT)
    return {
        "frames": tuple(_to_rows(frame) for frame in frames[:-1]),
        "axes": _to_rows(model.jnt_axis[:count]),
        "tool": _to_rows(frames[-1]),
        "camera": _to_rows(camera),
        "intrinsics": _intrinsics(model, "hand", width, height),
        "low": tuple(low.tolist()),
        "high": tuple(high.tolist()),
        "speed": tuple(model.actuator_ctrlrange[:, 1].tolist()),
        "capsules": tuple(capsules or tool_capsules(count + 1)),
        "stick_length": robot.STICK_LENGTH,
        "stick_radius": robot.STICK_RADIUS,
        "tool_mass": robot.TOOL_MASS,
        "reach": farthest,
        "nearest": nearest,
        "collisions": None if capsules else shapes,
    }


def _transform(model: mujoco.MjModel, above: int, below: int) -> FloatArray:
    """Return the fixed transform ``(4, 4)`` of a body in one above it.

    Only the lower body may have a joint, which moves it after this transform.
    """
    transform = np.eye(4)
    while below != above:
        body = model.body(below)
        transform = _homogeneous(to_matrix(body.quat), body.pos) @ transform
        below = int(model.body_parentid[below])
    return transform


def _homogeneous(rotation: FloatArray, position: FloatArray) -> FloatArray:
    """Return the transform ``(4, 4)`` of a rotation ``(3, 3)`` and a position ``(3,)``, m."""
    transform = np.eye(4)
    transform[:3, :3] = rotation
    transform[:3, 3] = position
    return transform


def _camera_transform(model: mujoco.MjModel, name: str) -> FloatArray:
    """Return the transform ``(4, 4)`` of a camera in its body, z into the image and y down."""
    number = model.camera(name).id
    from_mujoco = np.diag([1.0, -1.0, -1.0])  # whose cameras look along -z with y up
    rotation = to_matrix(model.cam_quat[number]) @ from_mujoco
    return _homogeneous(rotation, model.cam_pos[number])


def _intrinsics(
    model: mujoco.MjModel, name: str, width: int, height: int
) -> tuple[float, float, float, float, float]:
    """Return f, cₓ, c_y, width and height of a camera's image, px."""
    field_of_view = math.radians(model.cam_fovy[model.camera(name).id])
    focal_length = height / 2 / math.tan(field_of_view / 2)
    return focal_length, (width - 1) / 2, (height - 1) / 2, float(width), float(height)


def _to_rows(matrix: FloatArray) -> tuple[tuple[float, ...], ...]:
    return tuple(tuple(row) for row in matrix.tolist())
