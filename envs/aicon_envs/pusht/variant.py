"""The variants of the pushT task: one frozen dataclass of options."""

import dataclasses
import math
import operator
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from aicon_envs.pusht.geometry import Pose
from aicon_envs.pusht.simulation import SIZE

ActionMode = Literal["position", "velocity"]
StartDistribution = Literal["0.1.8", "0.1.5"]

DEFAULT_GOAL: Pose = (256.0, 256.0, math.pi / 4.0)
"""gym-pusht's goal, px and rad."""

RANDOM = "random"
"""Name of a goal that every reset draws."""

DEFAULT_SPEED = 800.0
"""Largest speed in the action mode "velocity" without a `velocity_limit`, px/s."""


@dataclasses.dataclass(frozen=True)
class Variant:
    """What differs from the usual pushT; the defaults are gym-pusht 0.1.8.

    Attributes:
        goal_pose: Goal of the object's frame (x, y, angle), px and rad, or "random".
        action_mode: "position" or "velocity".
        action_noise: Standard deviation of the noise on the pusher's target offset, px per axis and step.
        velocity_limit: Largest speed of the pusher, px/s; None for no limit ("velocity": 800).
        goal_jumps: How often the goal jumps to a random pose in an episode.
        goal_jump_interval: Fewest and most steps between jumps, both inclusive.
        kick_interval: Steps between kicks of the object; None for no kicks.
        kick: Largest shift, px, and largest turn, rad, of a kick.
        start_distribution: Version of gym-pusht whose seeded starts are drawn.
        legacy_reset: Whether `reset_to_state` sets what gym-pusht would set instead of exactly the given state.

    Raises:
        ValueError: If a value is not valid; the message names it and says what is.
    """

    goal_pose: Pose | Literal["random"] = DEFAULT_GOAL
    action_mode: ActionMode = "position"
    action_noise: float = 0.0
    velocity_limit: float | None = None
    goal_jumps: int = 0
    goal_jump_interval: tuple[int, int] = (40, 120)
    kick_interval: int | None = None
    kick: tuple[float, float] = (30.0, 0.5)
    start_distribution: StartDistribution = "0.1.8"
    legacy_reset: bool = False

    def __post_init__(self) -> None:
        """Check every value, and turn numbers and sequences into plain floats, integers and tuples."""
        _check_choice("action_mode", self.action_mode, get_args(ActionMode))
        _check_choice("start_distribution", self.start_distribution, get_args(StartDistribution))
        low, high = _check_interval(self.goal_jump_interval)
        shift, turn = _numbers("kick", self.kick, "two finite numbers >= 0: a shift in px and a turn in rad", 2)
        checked: dict[str, Any] = {
            "goal_pose": RANDOM if is_random(self.goal_pose) else check_pose("goal_pose", self.goal_pose),
            "action_noise": _check_number("action_noise", self.action_noise),
            "goal_jumps": _check_integer("goal_jumps", self.goal_jumps, 0),
            "goal_jump_interval": (low, high),
            "kick": (_check_number("kick", shift), _check_number("kick", turn)),
        }
        if self.velocity_limit is not None:
            checked["velocity_limit"] = _check_number("velocity_limit", self.velocity_limit, positive=True)
        if self.kick_interval is not None:
            checked["kick_interval"] = _check_integer("kick_interval", self.kick_interval, 1)
        for name, value in checked.items():
            object.__setattr__(self, name, value)

    @classmethod
    def from_options(cls, options: dict[str, Any]) -> "Variant":
        """Build the variant from keyword arguments.

        Raises:
            TypeError: If a name is unknown; the message lists the valid ones.
        """
        names = [field.name for field in dataclasses.fields(cls)]
        unknown = sorted(set(options) - set(names))
        if unknown:
            raise TypeError(f"unknown argument {', '.join(unknown)}; the options of a variant are {', '.join(names)}")
        return cls(**options)


def is_random(goal_pose: Any) -> bool:
    """Return whether a goal is to be drawn."""
    return isinstance(goal_pose, str) and goal_pose == RANDOM


def check_pose(name: str, value: ArrayLike) -> Pose:
    """Return a pose (x, y, angle) as plain floats.

    Raises:
        ValueError: If it is not three finite numbers, x and y in [0, 512] px and the angle in [-2π, 2π] rad.
    """
    expected = f"(x, y, angle), x and y in [0, {SIZE:g}] px and the angle in [-2π, 2π] rad"
    x, y, angle = _numbers(name, value, expected, 3)
    if not (0.0 <= x <= SIZE and 0.0 <= y <= SIZE and abs(angle) <= 2.0 * math.pi):
        raise ValueError(f"{name} must be {expected}, got {value!r}")
    return x, y, angle


def check_state(name: str, value: ArrayLike) -> tuple[float, float, float, float, float]:
    """Return a state (pusher x, y, block x, y, angle) as plain floats.

    Raises:
        ValueError: If it is not five finite numbers, the positions in [0, 512] px.
    """
    expected = f"(pusher x, y, block x, y, angle), all finite, x and y in [0, {SIZE:g}] px and the angle in rad"
    state = _numbers(name, value, expected, 5)
    if not all(0.0 <= each <= SIZE for each in state[:4]):
        raise ValueError(f"{name} must be {expected}, got {value!r}")
    pusher_x, pusher_y, x, y, angle = state
    return pusher_x, pusher_y, x, y, angle


def check_seed(name: str, value: Any) -> int:
    """Return a seed.

    Raises:
        ValueError: If it is not an integer >= 0.
    """
    return _check_integer(name, value, 0)


def _numbers(name: str, value: ArrayLike, expected: str, count: int) -> list[float]:
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{name} must be {expected}, got {value!r}") from error
    if array.shape != (count,) or not np.isfinite(array).all():
        raise ValueError(f"{name} must be {expected}, got {value!r}")
    numbers: list[float] = array.tolist()
    return numbers


def _check_choice(name: str, value: Any, choices: tuple[str, ...]) -> None:
    if value not in choices:
        raise ValueError(f"{name} must be one of {', '.join(choices)}, got {value!r}")


def _check_number(name: str, value: Any, positive: bool = False) -> float:
    expected = "a finite number > 0" if positive else "a finite number >= 0"
    try:
        number = float(value)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{name} must be {expected}, got {value!r}") from error
    if not math.isfinite(number) or number < 0.0 or (positive and number == 0.0):
        raise ValueError(f"{name} must be {expected}, got {value!r}")
    return number


def _check_integer(name: str, value: Any, least: int) -> int:
    try:
        number = operator.index(value)
    except TypeError:
        number = least - 1
    if number < least:
        raise ValueError(f"{name} must be an integer >= {least}, got {value!r}")
    return number


def _check_interval(value: Any) -> tuple[int, int]:
    expected = "goal_jump_interval must be two integers 1 <= fewest <= most"
    try:
        low, high = map(operator.index, value)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{expected}, got {value!r}") from error
    if not 1 <= low <= high:
        raise ValueError(f"{expected}, got {value!r}")
    return low, high
