"""The arms that push."""

from aicon_envs.reach.robots import ROBOTS, Robot

ARMS = {
    "panda": Robot(
        "panda_description/urdf/panda.urdf",
        "panda_link8",
        "panda_description/srdf/panda.srdf",
        (0.0, 0.3, 0.0, -2.2, 0.0, 2.5, 0.7853981633974483),
        gains=((4500.0, 450.0),) * 4 + ((2000.0, 200.0),) * 3,
        capsules="panda_description/urdf/panda_collision.urdf",
    ),
    "ur5": ROBOTS["ur5"],
}
"""Arms by name, for the push stick.

The root of each is where the base stands, level with the top of the table. The tip is its flange,
whose z axis points away from the arm; what hangs there (a hand) makes way for the stick.
"""
