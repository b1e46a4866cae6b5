"""Pushing an object to a pose: gym-pusht's task, its variants and other objects."""

from aicon_envs.pusht.environment import PushTEnv
from aicon_envs.pusht.objects import OBJECTS, PushObject, make_object
from aicon_envs.pusht.overlay import Overlay
from aicon_envs.pusht.vector import PushTVectorEnv

__all__ = ["OBJECTS", "Overlay", "PushObject", "PushTEnv", "PushTVectorEnv", "make_object"]
