"""An arm of spheres with a post in its way."""

import functools

import torch

from _inputs.reaching import planar_arm
from _inputs.shipped import quick
from aicon_torch import Policy, make_policy
from aicon_torch.models.reach import Robot
from aicon_torch.parts import Capsule, Capsules, Solid

POST = Solid("cylinder", (0.4, 0.05), position=(0.6, 0.3, 0.0))
"""Between the start and the target."""

START = torch.tensor([0.05, 0.05, 0.05], dtype=torch.float64)
TARGET = torch.tensor([0.2, 0.6, 0.0], dtype=torch.float64)


def beaded_arm() -> Robot:
    """Links of 30 cm in a plane, of five spheres each."""
    chain = planar_arm(shape=False).chain
    spheres = []
    for link in (1, 2, 3):
        for x in (0.06, 0.12, 0.18, 0.24, 0.3):
            spheres.append(Capsule(link, (x, 0.0, 0.0), (x, 0.0, 0.0), 0.03))
    return Robot(chain, Capsules(tuple(spheres), chain.names, ()))


@functools.cache
def policy(escapes: bool = True) -> Policy:
    """It reads two objects."""
    own = {} if escapes else {"dampers.escape": None}
    return quick(make_policy("reach", preset="clutter", robot=beaded_arm(), obstacles=2, **own))
