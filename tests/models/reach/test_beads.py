"""Of an arm that is many spheres none comes into another, though many are as near."""

import torch
from _inputs.reaching import planar_arm, reach

from aicon_torch import make_policy
from aicon_torch.models.reach import Robot
from aicon_torch.parts import Capsule, Capsules, SelfCollision, SquaredHinge

RADIUS, SLOW = 0.03, 8


def arm_beside_its_base() -> Robot:
    """Its first link has eight spheres of the base beside its axis, and a ninth beside its end."""
    chain = planar_arm(links=2, shape=False).chain
    spheres, pairs = [sphere(1, 0.002), sphere(1, 0.3), sphere(2, 0.3)], []
    for near, x, apart in (*[(0, 0.002, 0.0035)] * SLOW, (1, 0.3, 0.0055), (2, 0.3, 2.0)):
        pairs.append((len(spheres), near))
        spheres.append(sphere(0, x, -2 * RADIUS - apart))
    return Robot(chain, Capsules(tuple(spheres), chain.names, tuple(pairs)))


def sphere(link: int, x: float, y: float = 0.0) -> Capsule:
    """A sphere of a link."""
    return Capsule(link, (x, y, 0.0), (x, y, 0.0), RADIUS)


def test_the_ninth_sphere_is_kept_from_as_well() -> None:
    robot = arm_beside_its_base()
    assert robot.shape is not None
    policy = make_policy("reach", preset="clutter", robot=robot)
    below = torch.tensor([0.0, -0.6, 0.0], dtype=torch.float64)
    way, _ = reach(policy, torch.zeros(2).double(), seconds=0.2, target_position=below)

    itself = SelfCollision(
        robot.shape.capsules, SquaredHinge(0.0025, 1.0), robot.shape.pairs, robot.chain
    )
    assert (way[:, 0] < 0.0).any()
    assert itself.distances(way).amin() > 0.0
