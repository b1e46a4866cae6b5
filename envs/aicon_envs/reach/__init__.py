"""Reaching with any robot that a URDF describes, simulated by MuJoCo."""

import aicon_envs.panda_push.opengl  # noqa: F401  # before MuJoCo is imported
from aicon_envs.reach.environment import ReachEnv
from aicon_envs.reach.robots import ROBOTS, Robot

__all__ = ["ROBOTS", "ReachEnv", "Robot"]
