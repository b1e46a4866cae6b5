"""Which links of a robot may not touch each other."""

from collections import Counter
from collections.abc import Collection, Iterable
from itertools import combinations
from xml.etree import ElementTree

import mujoco
import numpy as np

from aicon_envs.arrays import FloatArray
from aicon_envs.reach.robots import Robot, draw_postures, find_file

Pair = frozenset[str]

SAMPLES = 200
"""Random postures in which it is seen which links always touch."""

ALWAYS = 0.95
"""Links that touch in more than this share of them always touch."""


def excluded_pairs(
    model: mujoco.MjModel,
    robot: Robot,
    joints: Collection[str],
    low: FloatArray,
    high: FloatArray,
) -> list[tuple[str, str]]:
    """Return the pairs of links whose contacts mean nothing.

    They are those that the SRDF disables, those that no joint or only one joint lies between, and
    those that touch in almost every posture.

    Args:
        model: The robot, compiled with all contacts.
        robot: Says where the SRDF is.
        joints: Names of the joints that move.
        low: Lower limits of the joints, ``(n,)``.
        high: Upper limits.
    """
    postures = draw_postures(low, high, SAMPLES, np.random.default_rng(0))
    meaningless = _disabled_pairs(robot) | _always_touching(model, joints, postures)

    excluded = []
    for numbers in combinations(range(1, model.nbody), 2):
        # The bodies that they are fixed to.
        one, other = model.body_weldid[list(numbers)].tolist()
        first, second = (model.body(number).name for number in numbers)
        is_near = one == other or _follow_each_other(model, one, other)
        if is_near or frozenset((first, second)) in meaningless:
            excluded.append((first, second))
    return excluded


def _follow_each_other(model: mujoco.MjModel, one: int, other: int) -> bool:
    """Whether only one joint lies between two groups of bodies."""
    above_one = model.body_weldid[model.body_parentid[one]]
    above_other = model.body_weldid[model.body_parentid[other]]
    return bool(above_one == other or above_other == one)


def _disabled_pairs(robot: Robot) -> set[Pair]:
    """Return the pairs of links that the SRDF says not to compare."""
    if robot.srdf is None:
        return set()

    root = ElementTree.parse(find_file(robot.srdf)).getroot()
    pairs = set()
    for element in root.iter("disable_collisions"):
        pairs.add(frozenset((str(element.get("link1")), str(element.get("link2")))))
    return pairs


def _always_touching(
    model: mujoco.MjModel, joints: Collection[str], postures: FloatArray
) -> set[Pair]:
    """Return the pairs of bodies that touch in almost every posture."""
    data = mujoco.MjData(model)
    addresses = [model.joint(name).qposadr[0] for name in joints]
    counts: Counter[Pair] = Counter()

    for posture in postures:
        data.qpos[addresses] = posture
        mujoco.mj_kinematics(model, data)
        mujoco.mj_collision(model, data)
        counts.update(set(_touching_pairs(model, data)))

    return {pair for pair, count in counts.items() if count > ALWAYS * len(postures)}


def _touching_pairs(model: mujoco.MjModel, data: mujoco.MjData) -> Iterable[Pair]:
    """Yield the pairs of bodies in contact."""
    for contact in data.contact[: data.ncon]:
        first, second = model.geom_bodyid[contact.geom]
        yield frozenset((model.body(first).name, model.body(second).name))
