"""Pushing an object to a pose with an arm, simulated by MuJoCo."""

import aicon_envs.arm_push.opengl  # noqa: F401  # before MuJoCo is imported
from aicon_envs.arm_push.arms import ARMS
from aicon_envs.arm_push.description import describe
from aicon_envs.arm_push.environment import ArmPushEnv
from aicon_envs.arm_push.objects import OBJECT_NAMES, PIXELS_PER_METRE, Prism, resolve_object

__all__ = [
    "ARMS",
    "OBJECT_NAMES",
    "PIXELS_PER_METRE",
    "ArmPushEnv",
    "Prism",
    "describe",
    "resolve_object",
]
