"""The arms that push, each as its URDF and what a URDF does not say."""

from dataclasses import dataclass

from aicon_envs.reach.robots import Robot


@dataclass(frozen=True)
class Arm(Robot):
    """An arm for the push stick.

    Its root is where the base stands, level with the top of the table. `tip` is its flange, whose z
    axis points away from the arm; what hangs there (a hand) makes way for the stick. `home` is
    where joint angles with the stick upright are searched from.

    Attributes:
        gains: Stiffness (Nm/rad) and damping (Nms/rad) of each joint's servo; by default the
            largest torque comes at 0.02 rad and the servo lags behind by 0.1 s, as a Panda's do.
        capsules: A URDF whose links are cylinders with round ends, by which the robot's distance to
            itself is told; by default that of its collision shapes is told, up to 50 mm.
    """

    gains: tuple[tuple[float, float], ...] | None = None
    capsules: str | None = None


ARMS = {
    "panda": Arm(
        "panda_description/urdf/panda.urdf",
        "panda_link8",
        "panda_description/srdf/panda.srdf",
        (0.0, 0.3, 0.0, -2.2, 0.0, 2.5, 0.7853981633974483),
        gains=((4500.0, 450.0),) * 4 + ((2000.0, 200.0),) * 3,
        capsules="panda_description/urdf/panda_collision.urdf",
    ),
    "ur5": Arm(
        "ur_description/urdf/ur5_joint_limited_robot.urdf",
        "tool0",
        "ur_description/srdf/ur5_joint_limited_robot.srdf",
        (0.0, -1.571, 1.571, -1.571, -1.571, 0.0),
    ),
}
"""Arms by name."""


def resolve_arm(robot: str | Arm) -> Arm:
    """Return the arm of a name, or the arm itself.

    Raises:
        ValueError: If there is none of this name; it lists those there are.
    """
    if isinstance(robot, Arm):
        return robot
    if not isinstance(robot, str) or robot not in ARMS:
        raise ValueError(f"robot must be an Arm or one of {', '.join(ARMS)}, got {robot!r}")

    return ARMS[robot]
