"""A wall follower: straight to the target, along walls until the turns along them cancel out."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from aicon_baselines.agents.nav2d.walls import (
    BoolArray,
    FloatArray,
    Surroundings,
    WallFollowing,
    cross,
    dot,
    restarted,
    sense,
    smaller_turn,
    tangent,
)


class Memory(NamedTuple):
    """What B agents remember.

    Attributes:
        is_following: Whether it follows a wall, (B,).
        side: 1 with the wall on the left, −1 on the right, (B,).
        turned: Angle from the target's direction to that of the motion, with full turns, (B,), rad.
    """

    is_following: BoolArray
    side: FloatArray
    turned: FloatArray


@dataclass(frozen=True)
class WallFollower(WallFollowing):
    """A wall follower with the leaving rule of Pledge's algorithm.

    It heads for the target until a wall is in the way, and follows the wall until it moves toward
    the target again *with its turns cancelled out*: the angle between the direction of the target
    and that of the wall, full turns included, is back at zero. So it does not fall back into a trap
    that it has just left, as it would if it left wherever the way is free.

    It adds up turns and knows no positions. Pledge's algorithm has a compass and a fixed direction;
    here the direction is the target's, which changes on the way. Beyond what AICON is given in
    the condition "range", it is given the direction of the nearest obstacle point, which AICON has
    to estimate there.

    Source: Abelson and diSessa, Turtle Geometry, 1980, chapter 4.
    """

    def predict(
        self,
        observation: dict[str, NDArray[Any]],
        state: Memory | None = None,
        episode_start: BoolArray | None = None,
        deterministic: bool = True,
    ) -> tuple[NDArray[np.float32], Memory]:
        """Choose the next velocities (B, 2); see `aicon_baselines.evaluation.Predictor`."""
        around = sense(observation)
        memory = _recall(around, state, episode_start)

        # 1. Whether it meets a wall, and on which side it will have it.
        hits = ~memory.is_following & self.meets_wall(around)
        side = np.where(hits, smaller_turn(around), memory.side)

        # 2. How far it has turned away: the angle changes by less than half a turn in a step.
        angle = _angle(around.to_target, tangent(around, side))
        change = _wrap(angle - memory.turned)
        turned = np.where(hits, angle, memory.turned + change)

        # 3. It leaves the wall where that is undone. The wall on the left turned it to the right.
        leaves = memory.is_following & (side * turned >= 0.0)
        is_following = (memory.is_following & ~leaves) | hits

        straight, along = self.head_for_target(around), self.follow(around, side)
        velocity = np.where(is_following[:, np.newaxis], along, straight)
        return velocity.astype(np.float32), Memory(is_following, side, turned)

    def explain(self, memory: Memory, row: int) -> str:
        """Say what an agent of the batch does."""
        if not memory.is_following[row]:
            return "heads for the target"

        hand = "left" if memory.side[row] > 0.0 else "right"
        turned = float(np.degrees(memory.turned[row]))
        return f"follows the wall on its {hand}, turned by {turned:+.0f}° from the target"


def _recall(around: Surroundings, state: Memory | None, episode_start: BoolArray | None) -> Memory:
    """The memory, anew where an episode begins: no wall was met yet."""
    count = len(around.clearance)
    fresh = Memory(np.zeros(count, np.bool_), np.ones(count), np.zeros(count))
    return fresh if state is None else restarted(fresh, state, episode_start)


def _angle(first: FloatArray, second: FloatArray) -> FloatArray:
    """Angle from the first to the second of unit vectors (B, 2), (B,), rad, in [−π, π]."""
    return np.arctan2(cross(first, second), dot(first, second))


def _wrap(angle: FloatArray) -> FloatArray:
    """The angle (B,) within [−π, π)."""
    return (angle + np.pi) % (2.0 * np.pi) - np.pi
