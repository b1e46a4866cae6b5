"""The settings of the pushT task: what differs from the benchmark, in one frozen dataclass."""

import dataclasses
import math
from typing import Any, Literal

from numpy.typing import ArrayLike

from aicon_envs.checks import check_integer, check_number, check_numbers
from aicon_envs.pusht.geometry import Pose
from aicon_envs.pusht.simulation import SIZE

State = tuple[float, float, float, float, float]
"""Pusher x, y, object x, y, px, and its angle, rad."""

DEFAULT_GOAL: Pose = (256.0, 256.0, math.pi / 4.0)
"""gym-pusht's goal, px and rad."""

RANDOM = "random"
"""Name of a goal that every reset draws."""

JUMP_INTERVAL = (40, 120)
"""Fewest and most steps between jumps of the goal, both inclusive."""

KICK = (30.0, 0.5)
"""Largest shift, px, and largest turn, rad, of a kick."""

_POSE = f"(x, y, angle), x and y in [0, {SIZE:g}] px and the angle in [-2π, 2π] rad"
_STATE = (
    "(pusher x, y, block x, y, angle), all finite, "
    f"x and y in [0, {SIZE:g}] px and the angle in rad"
)


@dataclasses.dataclass(frozen=True)
class TaskSettings:
    """What differs from the usual pushT; the defaults are gym-pusht 0.1.8.

    Attributes:
        goal_pose: Goal of the object's frame (x, y, angle), px and rad, or "random".
        action_noise: Standard deviation of the noise on the pusher's target offset, px per axis
            and step.
        velocity_limit: Largest speed of the pusher, px/s; None for no limit.
        goal_jumps: How often the goal jumps to a random pose in an episode.
        kick_interval: Steps between kicks of the object; None for no kicks.

    Raises:
        ValueError: If a value is not valid; the message names it and says what is.
    """

    goal_pose: Pose | Literal["random"] = DEFAULT_GOAL
    action_noise: float = 0.0
    velocity_limit: float | None = None
    goal_jumps: int = 0
    kick_interval: int | None = None

    def __post_init__(self) -> None:
        """Check every value; numbers and sequences become plain floats, integers and tuples."""
        self._set("action_noise", check_number("action_noise", self.action_noise))
        self._set("goal_jumps", check_integer("goal_jumps", self.goal_jumps, 0))

        # These may also be left open.
        if not is_random(self.goal_pose):
            self._set("goal_pose", check_pose("goal_pose", self.goal_pose))
        if self.velocity_limit is not None:
            limit = check_number("velocity_limit", self.velocity_limit, positive=True)
            self._set("velocity_limit", limit)
        if self.kick_interval is not None:
            self._set("kick_interval", check_integer("kick_interval", self.kick_interval, 1))

    def _set(self, name: str, value: Any) -> None:
        """Replace a value while a frozen instance is built."""
        object.__setattr__(self, name, value)


def is_random(goal_pose: Any) -> bool:
    """Return whether a goal is to be drawn."""
    return isinstance(goal_pose, str) and goal_pose == RANDOM


def check_pose(name: str, value: ArrayLike) -> Pose:
    """Return a pose (x, y, angle) as plain floats.

    Raises:
        ValueError: If it is not three finite numbers, x and y in [0, 512] px and the angle in
            [-2π, 2π] rad.
    """
    x, y, angle = check_numbers(name, value, _POSE, 3)

    in_world = 0.0 <= x <= SIZE and 0.0 <= y <= SIZE
    if not in_world or abs(angle) > 2.0 * math.pi:
        raise ValueError(f"{name} must be {_POSE}, got {value!r}")

    return x, y, angle


def check_state(name: str, value: ArrayLike) -> State:
    """Return a state (pusher x, y, object x, y, angle) as plain floats.

    Raises:
        ValueError: If it is not five finite numbers, the positions in [0, 512] px.
    """
    pusher_x, pusher_y, x, y, angle = check_numbers(name, value, _STATE, 5)

    for coordinate in (pusher_x, pusher_y, x, y):
        if not 0.0 <= coordinate <= SIZE:
            raise ValueError(f"{name} must be {_STATE}, got {value!r}")

    return pusher_x, pusher_y, x, y, angle
