"""Reaching with any robot that a URDF describes, simulated by MuJoCo."""

import aicon_envs.arm_push.opengl  # noqa: F401  # before MuJoCo is imported
from aicon_envs.reach.environment import ReachEnv
from aicon_envs.reach.robots import ROBOTS, Robot, find_file

__all__ = ["ROBOTS", "ReachEnv", "Robot", "find_file"]
