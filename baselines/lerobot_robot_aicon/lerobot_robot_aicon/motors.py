"""The motors of an arm, in the words of its description."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lerobot_robot_aicon.arm_options import ArmOptions

TURN = 2 * math.pi


class Motors:
    """Turns the radians of a description into the degrees of a robot's motors, and back.

    A motor shows s·q + o, where q is the joint's angle, degrees, s its sign and o its offset; and
    whole turns more or less, if it counts within a turn that the joint has left.

    Args:
        joints: Names of the description's joints.
        options: The motors that turn them, their offsets and signs.

    Raises:
        ValueError: If an option names a joint that the description does not have, a motor turns
            two joints, or a sign is neither 1 nor -1.

    Attributes:
        keys: The motors' keys in observations and actions: ``"elbow_flex.pos"``.
    """

    def __init__(self, joints: Sequence[str], options: ArmOptions) -> None:
        for name in ("motors", "offsets", "signs"):
            unknown = [joint for joint in getattr(options, name) if joint not in joints]
            if unknown:
                raise ValueError(
                    f"{name}: the description has no joint {', '.join(unknown)}; it has "
                    f"{', '.join(joints)}."
                )

        self.keys = [f"{options.motors.get(joint, joint)}.pos" for joint in joints]
        if len(set(self.keys)) < len(self.keys):
            raise ValueError(
                f"motors={options.motors!r}: a motor turns two joints; expected another one for "
                f"each, but they are {', '.join(self.keys)}."
            )

        self._offsets = np.array([options.offsets.get(joint, 0.0) for joint in joints])
        self.reset()
        self._signs = np.array([options.signs.get(joint, 1) for joint in joints])
        if not np.isin(self._signs, (-1, 1)).all():
            raise ValueError(f"signs={options.signs!r}: expected 1 or -1 for each joint.")

    def reset(self) -> None:
        """Take what the motors show as it is."""
        self._turns = np.zeros(len(self.keys))

    def turn(self, turns: NDArray[Any]) -> None:
        """Take each joint ``(n,)`` as so many turns less than its motor has shown until now."""
        self._turns += self._signs * turns

    def read(self, observation: Mapping[str, Any]) -> NDArray[Any]:
        """The joints ``(n,)``, rad, that motors show, degrees; what is not finite stays so.

        Raises:
            ValueError: If the observation lacks a motor, or has no number for it.
        """
        check_mapping("observation", observation, self.keys)
        missing = [key for key in self.keys if key not in observation]
        if missing:
            raise ValueError(
                f"observation: it has no {', '.join(missing)}; expected {', '.join(self.keys)}."
            )

        degrees = [as_number("observation", key, observation[key]) for key in self.keys]
        return np.radians(self._signs * (np.array(degrees) - self._offsets - 360 * self._turns))

    def told(self, action: Mapping[str, Any], near: NDArray[Any]) -> NDArray[Any]:
        """Where an action sends the joints ``(n,)``, rad.

        A motor that counts within one turn is told a place on any turn: the one that is nearest to
        where the joint is commanded to be ``(n,)``, rad, is meant.
        """
        joints = self.read(action)
        turns = np.where(self._turns == 0, 0.0, np.round((joints - near) / TURN))
        return joints - TURN * turns

    def written(self, joints: NDArray[Any]) -> dict[str, float]:
        """What the motors call joints ``(n,)``, degrees."""
        degrees = self._signs * np.degrees(joints) + self._offsets + 360 * self._turns
        return dict(zip(self.keys, degrees.tolist(), strict=True))


def finite(action: Mapping[str, Any]) -> dict[str, Any]:
    """What is finite of an action.

    Raises:
        ValueError: If something in it is no number.
    """
    return {
        key: value
        for key, value in action.items()
        if math.isfinite(as_number("action", key, value))
    }


def check_mapping(called: str, value: Any, keys: Sequence[str]) -> None:
    """Check that an observation or action, as it is ``called``, has its numbers by their keys.

    Raises:
        ValueError: If it has none.
    """
    if not isinstance(value, Mapping):
        raise ValueError(
            f"{called}: expected a dict of numbers by {', '.join(keys)}, "
            f"got {type(value).__name__}."
        )


def as_number(called: str, key: str, value: Any) -> float:
    """One number of an observation or action, as it is ``called``; it need not be finite.

    Raises:
        ValueError: If it is something else, such as None or a text.
    """
    try:
        if not isinstance(value, str):
            return float(value)
    except (TypeError, ValueError, OverflowError, RuntimeError):  # the last by a tensor of several
        pass
    raise ValueError(f"{called}: {key} is {value!r}; expected a number.")
