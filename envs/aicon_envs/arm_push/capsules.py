"""The robot as capsules, for distances of the robot to itself."""

from collections.abc import Sequence
from xml.etree import ElementTree

import mujoco
import numpy as np

from aicon_envs.arm_push import robot
from aicon_envs.arrays import FloatArray
from aicon_envs.reach.description_checks import link_name
from aicon_envs.reach.robots import Robot, find_file

Vector = tuple[float, float, float]

Capsule = tuple[int, Vector, Vector, float]
"""Link (0: base, i: after joint i, n + 1: tool), both ends in its frame (m), radius (m)."""


def robot_capsules(arm: Robot, model: mujoco.MjModel) -> list[Capsule]:
    """Return the capsules of an arm's description and those of the tool.

    Args:
        arm: The arm; without a description of its capsules there are none at all.
        model: The compiled scene, whose first joints are the arm's.

    Raises:
        ValueError: If the description of the capsules lacks one of them.
    """
    if arm.capsules is None:
        return []

    root = ElementTree.parse(find_file(arm.capsules)).getroot()
    numbers = _link_numbers(root, [model.joint(number).name for number in range(model.nu)])
    found: list[Capsule] = []

    for link in root.findall("link"):
        name = str(link.get("name"))
        for collision in link.findall("collision"):
            cylinder = collision.find("geometry/cylinder")
            if name in numbers and cylinder is not None:  # the spheres are the cylinders' ends
                found.append(_to_capsule(numbers[name], cylinder, collision.find("origin")))

    return found + tool_capsules(model.nu + 1)


def tool_capsules(tool: int) -> list[Capsule]:
    """Return the capsules of the stick and the camera, whose link has a number."""
    stick_end = (0.0, 0.0, robot.STICK_LENGTH - robot.STICK_RADIUS)
    stick = (tool, (0.0, 0.0, 0.0), stick_end, robot.STICK_RADIUS)

    # A short capsule across, around the camera's body.
    camera_x = robot.CAMERA[0]
    camera = (tool, (camera_x, -0.015, 0.01), (camera_x, 0.015, 0.01), 0.025)
    return [stick, camera]


def _link_numbers(root: ElementTree.Element, joints: Sequence[str]) -> dict[str, int]:
    """Return the number of each link that a joint moves, and 0 for the base."""
    numbers: dict[str, int] = {}

    for number, name in enumerate(joints, start=1):
        joint = root.find(f"joint[@name='{name}']")
        if joint is None:
            raise ValueError(f"capsules must be a URDF with the joint {name}, and has none")
        if number == 1:
            numbers[link_name(joint, "parent")] = 0
        numbers[link_name(joint, "child")] = number

    return numbers


def _to_capsule(
    link: int, cylinder: ElementTree.Element, origin: ElementTree.Element | None
) -> Capsule:
    """Return the capsule around a cylinder, whose axis is z in the frame of its origin."""
    middle = _parse_numbers(None if origin is None else origin.get("xyz"))
    roll_pitch_yaw = _parse_numbers(None if origin is None else origin.get("rpy"))

    length = float(str(cylinder.get("length")))
    radius = float(str(cylinder.get("radius")))
    # The angles are about the fixed axes, as URDF has it.
    quaternion = np.zeros(4)
    mujoco.mju_euler2Quat(quaternion, roll_pitch_yaw, "XYZ")
    half_axis = to_matrix(quaternion)[:, 2] * length / 2
    return link, _to_vector(middle - half_axis), _to_vector(middle + half_axis), radius


def to_matrix(quaternion: FloatArray) -> FloatArray:
    """Return the rotation ``(3, 3)`` of a quaternion (w, x, y, z)."""
    matrix = np.zeros(9)
    mujoco.mju_quat2Mat(matrix, quaternion)
    return matrix.reshape(3, 3)


def _parse_numbers(text: str | None) -> FloatArray:
    return np.array([float(number) for number in (text or "0 0 0").split()])


def _to_vector(values: FloatArray) -> Vector:
    x, y, z = values.tolist()
    return x, y, z
