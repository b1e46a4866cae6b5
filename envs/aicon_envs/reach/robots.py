"""The robots that come with `example-robot-data`, and where their files are."""

import importlib.metadata
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from aicon_envs.arrays import FloatArray
from aicon_envs.checks import check_numbers

_WIDEST = math.pi
"""Joints without limits are drawn from ± this, rad."""


@dataclass(frozen=True)
class Robot:
    """A robot that a URDF describes.

    Attributes:
        urdf: The file, or its path within `example-robot-data`, such as
            "panda_description/urdf/panda.urdf".
        tip: The link that reaches.
        srdf: Says which links need not be compared; the same kinds of path, or None.
        home: Where an episode may start, rad or m for each joint between root and tip; the middles
            of the joints' limits if None. From there a posture with the stick upright is searched.
        gains: Where the arm pushes, stiffness (Nm/rad) and damping (Nms/rad) of each joint's servo;
            by default the largest torque comes at 0.02 rad and the servo lags behind by 0.1 s, as a
            Panda's do.
        capsules: Where it pushes, a URDF whose links are cylinders with round ends, by which the
            robot's distance to itself is taken; by default it is that of its collision shapes, up
            to 50 mm.
    """

    urdf: str
    tip: str
    srdf: str | None = None
    home: tuple[float, ...] | None = None
    gains: tuple[tuple[float, float], ...] | None = None
    capsules: str | None = None

    def __post_init__(self) -> None:
        """Make tuples of lists and arrays: what is compiled for a robot is found again by it."""
        if self.home is not None:
            object.__setattr__(self, "home", tuple(np.ravel(self.home).tolist()))
        if self.gains is not None:
            pairs = np.atleast_2d(self.gains).tolist()
            object.__setattr__(self, "gains", tuple(map(tuple, pairs)))


ROBOTS = {
    "panda": Robot(
        "panda_description/urdf/panda.urdf",
        "panda_hand_tcp",
        "panda_description/srdf/panda.srdf",
        (0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785),
    ),
    "ur5": Robot(
        "ur_description/urdf/ur5_joint_limited_robot.urdf",
        "tool0",
        "ur_description/srdf/ur5_joint_limited_robot.srdf",
        (0.0, -1.571, 1.571, -1.571, -1.571, 0.0),
    ),
    "ur3": Robot(
        "ur_description/urdf/ur3_joint_limited_robot.urdf",
        "tool0",
        "ur_description/srdf/ur5_joint_limited_robot.srdf",
        (0.0, -1.571, 1.571, -1.571, -1.571, 0.0),
    ),
    "ur10": Robot(
        "ur_description/urdf/ur10_joint_limited_robot.urdf",
        "tool0",
        "ur_description/srdf/ur5_joint_limited_robot.srdf",
        (0.0, -1.571, 1.571, -1.571, -1.571, 0.0),
    ),
    "xarm7": Robot(
        "xarm_description/urdf/xarm7.urdf",
        "link7",
        "xarm_description/srdf/xarm7.srdf",
        (0.0, -0.247, 0.0, 0.909, 0.0, 1.156, 0.0),
    ),
    "so101": Robot("so_arm_description/urdf/so101.urdf", "gripper_frame_link"),
    "z1": Robot(
        "z1_description/urdf/z1.urdf",
        "gripperStator",
        "z1_description/srdf/z1.srdf",
        (0.0, 0.785, -0.785, -0.3, 0.0, 0.0),
    ),
    "kinova": Robot(
        "kinova_description/robots/kinova.urdf",
        "j2s6s200_end_effector",
        "kinova_description/srdf/kinova.srdf",
        (1.571, 2.618, 4.712, 3.142, 2.618, 0.0),
    ),
    "tiago": Robot("tiago_description/robots/tiago.urdf", "arm_tool_link"),
}
"""Robots by name; their arms start as their makers' examples do."""


def resolve_robot(robot: str | Robot, known: Mapping[str, Robot] = ROBOTS) -> Robot:
    """Return the robot of a name, or the robot itself.

    Args:
        robot: The name, or the robot.
        known: Robots by name.

    Raises:
        ValueError: If there is none of this name; it lists those there are.
    """
    if isinstance(robot, Robot):
        return robot
    if not isinstance(robot, str) or robot not in known:
        raise ValueError(f"robot must be a Robot or one of {', '.join(known)}, got {robot!r}")

    return known[robot]


def find_home(robot: Robot, low: FloatArray, high: FloatArray) -> FloatArray:
    """Return a robot's home, ``(n,)``; by default the middles of its limits, 0 without.

    Args:
        robot: The robot.
        low: Lower limits of its joints, ``(n,)``, rad or m.
        high: Upper limits.

    Raises:
        ValueError: If it has another number of joints, or is not within their limits.
    """
    if robot.home is None:
        return np.where(np.isfinite(low), (low + high) / 2.0, 0.0)
    return check_posture("home", robot.home, low, high)


def check_posture(name: str, values: Any, low: FloatArray, high: FloatArray) -> FloatArray:
    """Return values of n joints that are within their limits, ``(n,)``, rad or m.

    Raises:
        ValueError: If they are not so many, or not within; it names them.
    """
    expected = f"{len(low)} finite numbers within the limits, in rad or m"
    posture = np.array(check_numbers(name, values, expected, len(low)))
    if (posture < low).any() or (posture > high).any():
        raise ValueError(f"{name} must be {expected}, got {posture.tolist()}")
    return posture


def draw_postures(
    low: FloatArray, high: FloatArray, count: int, generator: np.random.Generator
) -> FloatArray:
    """Return values of n joints within their limits, ``(count, n)``; ±π where there are none."""
    bounded = np.isfinite(low)
    least, most = np.where(bounded, low, -_WIDEST), np.where(bounded, high, _WIDEST)
    return generator.uniform(least, most, (count, len(low)))


def find_file(name: str) -> Path:
    """Return the file of a path, or of a path within `example-robot-data`.

    Raises:
        FileNotFoundError: If there is none.
        ModuleNotFoundError: If the package is missing.
    """
    path = Path(name)
    if path.is_file():
        return path.resolve()

    try:
        files = importlib.metadata.files("example-robot-data") or []
    except importlib.metadata.PackageNotFoundError as error:
        raise ModuleNotFoundError(
            "the descriptions of robots are missing; "
            "they come with: pip install 'aicon-torch[reach]'"
        ) from error

    for file in files:
        if str(file).endswith(f"example-robot-data/robots/{name}"):
            return Path(str(file.locate())).resolve()
    raise FileNotFoundError(f"{name} is no file, and no file of example-robot-data's robots")
