"""Pushing an object to a pose with a Panda arm, simulated by MuJoCo."""

import aicon_envs.panda_push.opengl  # noqa: F401  # before MuJoCo is imported
from aicon_envs.panda_push.description import describe
from aicon_envs.panda_push.environment import PandaPushEnv
from aicon_envs.panda_push.objects import (
    OBJECT_NAMES,
    PIXELS_PER_METRE,
    Prism,
    resolve_object,
)

__all__ = [
    "OBJECT_NAMES",
    "PIXELS_PER_METRE",
    "PandaPushEnv",
    "Prism",
    "describe",
    "resolve_object",
]
