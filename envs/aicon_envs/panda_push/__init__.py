"""Pushing an object to a pose with a Panda arm, simulated by MuJoCo."""

import aicon_envs.panda_push.opengl  # noqa: F401  # before MuJoCo is imported
from aicon_envs.panda_push.description import describe
from aicon_envs.panda_push.environment import PandaPushEnv
from aicon_envs.panda_push.objects import PIXELS_PER_METRE, Prism, names, resolve_object

__all__ = ["PIXELS_PER_METRE", "PandaPushEnv", "Prism", "describe", "names", "resolve_object"]
