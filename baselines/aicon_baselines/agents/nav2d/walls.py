"""What a wall-following agent senses, and how it follows the wall."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any, ClassVar, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from aicon_envs.nav2d import Physics
from aicon_torch.validation import check_positive

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

Remembered = TypeVar("Remembered", bound=tuple[Any, ...])
"""What an agent remembers: a named tuple of arrays, a row for each of B agents."""


class Surroundings(NamedTuple):
    """What is sensed in a step, of B agents.

    Attributes:
        to_target: Unit vector toward the target, (B, 2).
        to_obstacle: Unit vector toward the nearest obstacle point, (B, 2).
        clearance: Distance to that point minus the radius, (B,), m.
    """

    to_target: FloatArray
    to_obstacle: FloatArray
    clearance: FloatArray


@dataclass(frozen=True)
class WallFollowing:
    """Motion toward the target and along walls, at constant speed.

    An agent heads for the target. It meets a wall where the clearance is below `contact` and the
    nearest point is on the target's side, and turns to where the turn is smaller. Along the wall it
    moves by v = s (√(1 − u²) t + u o), with the direction o to the nearest point, the tangent t and
    u = k (d − d*), limited to ±0.9: proportional control of the clearance d.

    Attributes:
        speed: s, m/s.
        clearance: d*, m.
        gain: k, 1/m.
        contact: Clearance at which a wall is met, m.
        env_options: What it has to be told: the direction of the nearest obstacle point.
    """

    speed: float = Physics().max_speed
    clearance: float = 0.06
    gain: float = 8.0
    contact: float = 0.1

    env_options: ClassVar[Mapping[str, Any]] = {"sensing": "range_bearing"}

    def __post_init__(self) -> None:
        """Check the options, which are all positive."""
        check_positive(self, [field.name for field in fields(self)])

    def meets_wall(self, around: Surroundings) -> BoolArray:
        """Whether a wall is near and in the way, (B,)."""
        is_near = around.clearance < self.contact
        is_in_the_way = dot(around.to_obstacle, around.to_target) > 0.0
        return is_near & is_in_the_way

    def head_for_target(self, around: Surroundings) -> FloatArray:
        """Velocity straight to the target, (B, 2), m/s."""
        return self.speed * around.to_target

    def follow(self, around: Surroundings, side: FloatArray) -> FloatArray:
        """Velocity along the wall, (B, 2), m/s.

        Args:
            around: What is sensed.
            side: 1 with the wall on the left, −1 with the wall on the right, (B,).
        """
        error = around.clearance - self.clearance
        toward = np.clip(self.gain * error, -0.9, 0.9)[:, np.newaxis]
        along = np.sqrt(1.0 - toward**2)

        direction = along * tangent(around, side) + toward * around.to_obstacle
        return self.speed * direction


def restarted(fresh: Remembered, memory: Remembered, episode_start: BoolArray | None) -> Remembered:
    """The memory, anew in rows (B,) that begin an episode."""
    if episode_start is None:
        return memory

    rows = []
    for new, old in zip(fresh, memory, strict=True):
        starts = episode_start if new.ndim == 1 else episode_start[:, np.newaxis]
        rows.append(np.where(starts, new, old))
    return type(fresh)(*rows)


def sense(observation: Mapping[str, NDArray[Any]]) -> Surroundings:
    """What the readings (B, 1) say."""
    return Surroundings(
        to_target=_unit_vectors(observation["bearing"]),
        to_obstacle=_unit_vectors(observation["obstacle_bearing"]),
        clearance=observation["range"][:, 0].astype(np.float64),
    )


def smaller_turn(around: Surroundings) -> FloatArray:
    """The side, (B,), on which to have the wall so as to turn less from the target's direction."""
    with_wall_left = tangent(around, np.ones(len(around.clearance)))
    return np.where(dot(with_wall_left, around.to_target) >= 0.0, 1.0, -1.0)


def tangent(around: Surroundings, side: FloatArray) -> FloatArray:
    """Unit vector along the wall, (B, 2), with the wall on the left (1) or on the right (−1)."""
    x, y = around.to_obstacle.T
    with_wall_left = np.stack([y, -x], axis=-1)

    direction: FloatArray = side[:, np.newaxis] * with_wall_left
    return direction


def dot(first: FloatArray, second: FloatArray) -> FloatArray:
    """Products of vectors (B, 2), (B,)."""
    products: FloatArray = first[:, 0] * second[:, 0] + first[:, 1] * second[:, 1]
    return products


def cross(first: FloatArray, second: FloatArray) -> FloatArray:
    """First × second of vectors (B, 2), (B,): positive where the second is to the left."""
    products: FloatArray = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
    return products


def _unit_vectors(angles: NDArray[Any]) -> FloatArray:
    """Unit vectors (B, 2) of angles (B, 1), rad."""
    angles = angles.astype(np.float64)
    return np.concatenate([np.cos(angles), np.sin(angles)], axis=-1)
