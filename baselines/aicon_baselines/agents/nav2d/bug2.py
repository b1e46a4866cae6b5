"""Bug 2: straight to the target, around obstacles, and on where the straight line is met again."""

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
)
from aicon_envs.nav2d import Physics


class Memory(NamedTuple):
    """What B agents remember.

    Attributes:
        is_following: Whether it follows a wall, (B,).
        side: 1 with the wall on the left, −1 on the right, (B,).
        to_target: Mean direction to the target, a unit vector, (B, 2).
        line: Direction of the line from the hit point to the target, (B, 2).
        displacement: Way from the hit point, by odometry, (B, 2), m.
        offset: Where it was beside that line in the last step, (B,), m; positive to its left.
    """

    is_following: BoolArray
    side: FloatArray
    to_target: FloatArray
    line: FloatArray
    displacement: FloatArray
    offset: FloatArray


@dataclass(frozen=True)
class Bug2(WallFollowing):
    """Bug 2 of Lumelsky and Stepanov (1987), with noisy sensors of direction and clearance.

    It heads for the target until a wall is in the way. It follows the wall until it is back on the
    straight line from this hit point to the target, by at least `progress` nearer to the target,
    which is still ahead. There it leaves the wall, or hits it anew.

    The original knows its position and the target's exactly, and has one line, from the start. This
    one is given less: the bearing of the target, from which it takes the direction of a new line at
    each hit point, and its own commands, which it adds up to know where it is beside that line.
    Beyond what AICON is given in the condition "range", it is given the direction of the nearest
    obstacle point, which AICON has to estimate there.

    Attributes:
        progress: By how much the leave point has to be nearer than the hit point, m.
        bearing_time: Time constant of the mean of the bearings that a line is drawn by, s.
    """

    progress: float = 0.1
    bearing_time: float = 0.5

    def predict(
        self,
        observation: dict[str, NDArray[Any]],
        state: Memory | None = None,
        episode_start: BoolArray | None = None,
        deterministic: bool = True,
    ) -> tuple[NDArray[np.float32], Memory]:
        """Choose the next velocities (B, 2); see `aicon_baselines.evaluation.Predictor`."""
        around = sense(observation)
        memory = self._recall(around, state, episode_start)

        # 1. Where it is beside the line of its hit point, and whether it leaves the wall.
        offset = cross(memory.line, memory.displacement)
        leaves = memory.is_following & self._may_leave(around, memory, offset)

        # 2. Whether it meets a wall: there a new line begins.
        hits = ~memory.is_following & self.meets_wall(around)
        is_following = (memory.is_following & ~leaves) | hits
        side = np.where(hits, smaller_turn(around), memory.side)
        line = np.where(hits[:, np.newaxis], memory.to_target, memory.line)

        # 3. Go on, and add up what was commanded since the hit point.
        straight, along = self.head_for_target(around), self.follow(around, side)
        velocity = np.where(is_following[:, np.newaxis], along, straight)
        displacement = np.where(hits[:, np.newaxis], 0.0, memory.displacement)
        displacement = displacement + velocity * Physics().dt

        offset = np.where(hits, 0.0, offset)
        memory = Memory(is_following, side, memory.to_target, line, displacement, offset)
        return velocity.astype(np.float32), memory

    def explain(self, memory: Memory, row: int) -> str:
        """Say what an agent of the batch does."""
        if not memory.is_following[row]:
            return "heads for the target"

        hand = "left" if memory.side[row] > 0.0 else "right"
        offset = float(cross(memory.line, memory.displacement)[row])
        progress = float(dot(memory.line, memory.displacement)[row])
        return (
            f"follows the wall on its {hand}, {offset:+.2f} m beside the line and "
            f"{progress:+.2f} m along it from the hit point"
        )

    def _recall(
        self, around: Surroundings, state: Memory | None, episode_start: BoolArray | None
    ) -> Memory:
        """The memory, anew where an episode begins, with the mean bearing of this step."""
        fresh = _fresh(around)
        if state is None:
            return fresh

        # The low-pass of the bearing, as a unit vector.
        rate = Physics().dt / (Physics().dt + self.bearing_time)
        mean = state.to_target + rate * (around.to_target - state.to_target)
        length = np.linalg.norm(mean, axis=-1, keepdims=True)
        memory = state._replace(to_target=mean / np.maximum(length, 1e-9))

        return restarted(fresh, memory, episode_start)

    def _may_leave(self, around: Surroundings, memory: Memory, offset: FloatArray) -> BoolArray:
        """Whether the line is crossed, nearer to a target that is still ahead."""
        crosses = offset * memory.offset < 0.0
        is_nearer = dot(memory.line, memory.displacement) > self.progress
        is_ahead = dot(memory.line, around.to_target) > 0.0

        may_leave: BoolArray = crosses & is_nearer & is_ahead
        return may_leave


def _fresh(around: Surroundings) -> Memory:
    """What is remembered before the first step: no wall was met yet."""
    count = len(around.clearance)
    return Memory(
        is_following=np.zeros(count, np.bool_),
        side=np.ones(count),
        to_target=around.to_target,
        line=around.to_target,
        displacement=np.zeros((count, 2)),
        offset=np.zeros(count),
    )
