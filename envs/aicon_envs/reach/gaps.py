"""How far the robot is from itself and from the balls, by MuJoCo's own collision detection."""

import copy
from typing import NamedTuple, TypeVar

import mujoco

from aicon_envs.arrays import FloatArray

SIGHT = 0.05
"""Gaps are measured up to this, m."""


Some = TypeVar("Some", bound=NamedTuple)


class Gaps(NamedTuple):
    """Smallest gaps, m: at most `SIGHT`, and below 0 where something touches."""

    to_itself: float
    to_balls: float


def smaller(one: Some, other: Some) -> Some:
    """The smaller gap of each kind."""
    return one._make(map(min, one, other))


def seeing_near(model: mujoco.MjModel) -> mujoco.MjModel:
    """A copy of a scene in which MuJoCo lists what is near, not only what touches."""
    found = copy.copy(model)
    found.geom_margin[:] = SIGHT / 2.0  # the margins of two shapes add up
    found.geom_gap[:] = 0.0
    return found


class GapMeter:
    """Measures gaps between the collision shapes of a scene that can meet.

    Args:
        model: The compiled scene.
    """

    def __init__(self, model: mujoco.MjModel) -> None:
        """Make a copy of the scene that sees what is near."""
        self._model = seeing_near(model)
        self._data = mujoco.MjData(self._model)

        bodies = self._model.geom_bodyid
        self._is_ball = self._model.body_mocapid[bodies] >= 0

    def __call__(self, positions: FloatArray, balls: FloatArray) -> Gaps:
        """Return the gaps in a state.

        Args:
            positions: MuJoCo's `qpos`.
            balls: MuJoCo's `mocap_pos`.
        """
        data = self._data
        data.qpos[:], data.mocap_pos[:] = positions, balls
        mujoco.mj_kinematics(self._model, data)
        mujoco.mj_collision(self._model, data)
        return self.near(data)

    def near(self, data: mujoco.MjData) -> Gaps:
        """Return the gaps among the contacts that MuJoCo has listed."""
        distances = data.contact.dist
        with_ball = self._is_ball[data.contact.geom].any(axis=1)
        return Gaps(
            to_itself=float(distances[~with_ball].min(initial=SIGHT)),
            to_balls=float(distances[with_ball].min(initial=SIGHT)),
        )
