"""Pushing an object to a pose: gym-pusht's task, its variants and other objects."""

from aicon_envs.pusht.environment import PushTEnv
from aicon_envs.pusht.goal import Goal
from aicon_envs.pusht.objects import OBJECTS, PushObject, make_object
from aicon_envs.pusht.settings import DEFAULT_GOAL, TaskSettings

__all__ = [
    "DEFAULT_GOAL",
    "OBJECTS",
    "Goal",
    "PushObject",
    "PushTEnv",
    "TaskSettings",
    "make_object",
]
