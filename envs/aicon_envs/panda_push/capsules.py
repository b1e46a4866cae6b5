"""The robot as capsules, for distances of the robot to itself."""

from xml.etree import ElementTree

import mujoco
import numpy as np
from numpy.typing import NDArray

from aicon_envs.panda_push import robot, urdf

FloatArray = NDArray[np.float64]

Vector = tuple[float, float, float]

Capsule = tuple[int, Vector, Vector, float]
"""Link (0 is the base, 8 the tool), both ends in its frame (m), radius (m)."""

TOOL_LINK = 8
"""Number of the tool among the links."""


def robot_capsules() -> list[Capsule]:
    """Return the capsules of the arm's collision description, and those of the tool."""
    root = urdf.load_collision_model()
    found: list[Capsule] = []

    for link in root.findall("link"):
        # The flange (link 8) has the tool's number, and other links, of the hand, no number.
        number = str(link.get("name")).removeprefix("panda_link")
        if not number.isdigit() or int(number) >= TOOL_LINK:
            continue

        for collision in link.findall("collision"):
            cylinder = collision.find("geometry/cylinder")
            if cylinder is not None:  # the spheres are the ends of the cylinders
                found.append(_to_capsule(int(number), cylinder, collision.find("origin")))

    return found + _tool_capsules()


def _tool_capsules() -> list[Capsule]:
    stick_end = (0.0, 0.0, robot.STICK_LENGTH - robot.STICK_RADIUS)
    stick = (TOOL_LINK, (0.0, 0.0, 0.0), stick_end, robot.STICK_RADIUS)

    # A short capsule across, around the camera's body.
    camera_x = robot.CAMERA[0]
    camera = (TOOL_LINK, (camera_x, -0.015, 0.01), (camera_x, 0.015, 0.01), 0.025)
    return [stick, camera]


def _to_capsule(
    link: int, cylinder: ElementTree.Element, origin: ElementTree.Element | None
) -> Capsule:
    """Return the capsule around a cylinder, whose axis is z in the frame of its origin."""
    middle = _parse_numbers(None if origin is None else origin.get("xyz"))
    roll_pitch_yaw = _parse_numbers(None if origin is None else origin.get("rpy"))

    length = float(str(cylinder.get("length")))
    radius = float(str(cylinder.get("radius")))
    half_axis = _to_matrix(roll_pitch_yaw)[:, 2] * length / 2
    return link, _to_vector(middle - half_axis), _to_vector(middle + half_axis), radius


def _to_matrix(roll_pitch_yaw: FloatArray) -> FloatArray:
    """Return the rotation ``(3, 3)`` by angles about the fixed axes, as URDF has it."""
    quaternion, matrix = np.zeros(4), np.zeros(9)
    mujoco.mju_euler2Quat(quaternion, roll_pitch_yaw, "XYZ")
    mujoco.mju_quat2Mat(matrix, quaternion)
    return matrix.reshape(3, 3)


def _parse_numbers(text: str | None) -> FloatArray:
    return np.array([float(number) for number in (text or "0 0 0").split()])


def _to_vector(values: FloatArray) -> Vector:
    x, y, z = values.tolist()
    return x, y, z
