"""How far the robot's links are from each other."""

import copy
from collections.abc import Callable, Sequence

import mujoco
import numpy as np
from numpy.typing import NDArray

from aicon_envs.arm_push import collision_groups
from aicon_envs.arm_push.capsules import Capsule
from aicon_envs.arrays import FloatArray
from aicon_envs.reach.gaps import GapMeter

SelfDistance = Callable[[mujoco.MjData], float]

NEIGHBOURS = 2
"""Links that follow each other within this number cannot meet."""

_EPSILON = 1e-12
"""Instead of the squared length of a segment without one, m², and of a vanishing determinant."""


def self_distance(model: mujoco.MjModel, capsules: Sequence[Capsule]) -> SelfDistance:
    """Return what tells the smallest gap of the robot to itself in a state, m.

    Args:
        model: The compiled scene.
        capsules: The robot's; without any the gap of its collision shapes is taken.
    """
    return CapsuleDistance(model, capsules) if capsules else ShapeDistance(model)


class ShapeDistance:
    """The smallest gap between collision shapes of the robot that can meet, up to 50 mm.

    Args:
        model: The compiled scene.
    """

    def __init__(self, model: mujoco.MjModel) -> None:
        """Take all but the robot out of a copy of the scene's collisions."""
        alone = copy.copy(model)
        others = model.geom_contype != collision_groups.ROBOT
        alone.geom_contype[others] = alone.geom_conaffinity[others] = collision_groups.FREE
        self._measure = GapMeter(alone)

    def __call__(self, data: mujoco.MjData) -> float:
        """Return the gap in a state, m; below 0 where they overlap."""
        return self._measure(data.qpos, data.mocap_pos).to_itself


class CapsuleDistance:
    """The smallest gap between capsules of the robot that can meet.

    Args:
        model: The compiled scene.
        capsules: The robot's.
    """

    def __init__(self, model: mujoco.MjModel, capsules: Sequence[Capsule]) -> None:
        """Find the bodies of the capsules, and the pairs that can meet."""
        links = [link for link, _, _, _ in capsules]
        radii = np.array([radius for _, _, _, radius in capsules])
        numbers = _link_bodies(model)

        self._bodies = np.array([numbers[link] for link in links])
        self._starts = np.array([start for _, start, _, _ in capsules])
        self._along = np.array([end for _, _, end, _ in capsules]) - self._starts

        self._first, self._second = _pairs_that_can_meet(links)
        self._radii = radii[self._first] + radii[self._second]

    def __call__(self, data: mujoco.MjData) -> float:
        """Return the gap in a state, m; below 0 where they overlap."""
        # The capsules' axes in the world.
        rotations = data.xmat[self._bodies].reshape(-1, 3, 3)
        starts = data.xpos[self._bodies] + np.einsum("nij,nj->ni", rotations, self._starts)
        along = np.einsum("nij,nj->ni", rotations, self._along)

        first, second = self._first, self._second
        distances = _segment_distances(starts[first], along[first], starts[second], along[second])
        return float((distances - self._radii).min())


def _link_bodies(model: mujoco.MjModel) -> list[int]:
    """Return the bodies of the base, of the links after the joints, and of the tool."""
    moved = model.jnt_bodyid[: model.nu].tolist()
    return [int(model.body_parentid[moved[0]]), *moved, int(model.body("tool").id)]


def _pairs_that_can_meet(links: list[int]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the indices of both capsules of each pair, whose links are given."""
    pairs = []

    for later, link in enumerate(links):
        for earlier in range(later):
            if abs(link - links[earlier]) > NEIGHBOURS:
                pairs.append((later, earlier))

    first, second = np.array(pairs).T
    return first, second


def _segment_distances(
    start: FloatArray, along: FloatArray, other_start: FloatArray, other_along: FloatArray
) -> FloatArray:
    """Return the distances of N pairs of segments, ``(N,)``, m.

    Each segment goes from a start along a vector, all ``(N, 3)``. The nearest points lie at shares
    s and t of them: the unbounded solution for s, clipped to [0, 1], then the best t for this s,
    clipped, then the best s for this t.
    """
    offset = start - other_start
    a = (along * along).sum(-1)
    b = (along * other_along).sum(-1)
    c = (other_along * other_along).sum(-1)
    d = (along * offset).sum(-1)
    e = (other_along * offset).sum(-1)

    # Alternately the best share of one segment for that of the other.
    s = np.clip((b * e - c * d) / np.maximum(a * c - b * b, _EPSILON), 0.0, 1.0)
    t = np.clip((b * s + e) / np.maximum(c, _EPSILON), 0.0, 1.0)
    s = np.clip((b * t - d) / np.maximum(a, _EPSILON), 0.0, 1.0)

    gap = offset + s[:, None] * along - t[:, None] * other_along
    distances: FloatArray = np.sqrt((gap * gap).sum(-1))
    return distances
