"""The joints of an arm as they were commanded last."""

import logging
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from aicon_torch.parts.chain import Chain
from lerobot_robot_aicon.arm_options import ArmOptions
from lerobot_robot_aicon.measured_joints import Believed, MeasuredJoints
from lerobot_robot_aicon.motors import TURN, Motors

_log = logging.getLogger(__name__)


class ArmState(NamedTuple):
    """How an arm stands before a step.

    Attributes:
        commanded: Where its joints were sent ``(n,)``, rad, no further ahead than the lead.
        measured: Where they are ``(n,)``, rad.
        begins: Whether an episode begins.
        is_held: Whether a motor shows what cannot be, or has not been read twice: the arm is sent
            where it was sent, which is nowhere at first.
        is_displaced: Whether it stands farther from where it was sent than it can have come by
            itself, and is to be sent to where it is before anything else.
    """

    commanded: NDArray[np.float64]
    measured: NDArray[np.float64]
    begins: bool = False
    is_held: bool = False
    is_displaced: bool = False


class CommandedJoints:
    """Where joints were sent last.

    What moves next is computed for the joints *as they were commanded*, which servos follow with a
    lag; they run ahead of the true ones by the configured lead at most, so that an arm that is
    held, or pushed, is not left behind.

    Readings that cannot be true do not count: see :class:`MeasuredJoints`. Where four in a row
    agree on another place, the arm was moved there, and what is commanded follows it step by step.
    A joint that can turn more than once is sent to a place on the turn that its motor shows.

    Args:
        chain: The description's joints.
        options: The motors that turn them, and the lead.

    Raises:
        ValueError: If an option names a joint that the description does not have.

    Attributes:
        motors: The motors.
    """

    def __init__(self, chain: Chain, options: ArmOptions) -> None:
        self.motors = Motors(chain.names, options)
        self._measured = MeasuredJoints(chain, options)
        self._lead = np.radians(options.lead)
        self._fps = options.fps
        self.reset()

    @property
    def keys(self) -> list[str]:
        """The motors' keys in observations and actions."""
        return self.motors.keys

    def reset(self) -> None:
        """Forget where they were sent."""
        self.motors.reset()
        self._measured.reset()
        self._commanded: NDArray[np.float64] | None = None
        self._is_held = self._is_displaced = False

    def look(self, observation: Mapping[str, Any]) -> ArmState:
        """How the arm stands.

        Raises:
            ValueError: If the observation lacks a motor, or an episode begins with an arm of which
                a motor shows nothing, or what is beyond the joint's stops.
        """
        reading = self.motors.read(observation)
        if self._commanded is None:
            return self._begin(observation, reading)

        turns = self._measured.turns(reading, self._commanded)
        self.motors.turn(turns)
        reading = reading - TURN * turns

        believed = self._measured(reading, self._commanded)
        self._warn(observation, believed)
        self._is_held = not believed.is_believed.all()
        self._is_displaced |= bool(believed.has_jumped.any())
        measured = believed.joints
        if self._is_held:
            return ArmState(self._commanded, measured, is_held=True)

        # An arm that was moved is followed until it is within the lead; another one is there.
        within = np.clip(self._commanded, measured - self._lead, measured + self._lead)
        self._is_displaced &= not np.array_equal(within, self._commanded)
        if self._is_displaced:
            return ArmState(self._commanded, measured, is_displaced=True)
        return ArmState(within, measured)

    def stays(self) -> dict[str, float]:
        """Where the motors were sent last, degrees; nothing before the first time."""
        return {} if self._commanded is None else self.motors.written(self._commanded)

    def moved(self, commanded: NDArray[Any], velocity: Any) -> dict[str, float]:
        """Where the motors are sent next, degrees: a step of a velocity ``(n,)``, rad/s, on."""
        self._commanded = commanded + np.asarray(velocity) / self._fps
        return self.motors.written(self._commanded)

    def _begin(self, observation: Mapping[str, Any], reading: NDArray[np.float64]) -> ArmState:
        """How an arm stands that was not sent anywhere: two readings in a row must agree."""
        agrees = self._measured.begin(reading)
        was_held, self._is_held = self._is_held, not agrees.all()
        if was_held and self._is_held:
            shown = self._shown(observation, ~agrees)
            _log.warning("The arm is not moved: two readings in a row do not agree, %s.", shown)
        return ArmState(reading, reading, begins=not self._is_held, is_held=self._is_held)

    def _warn(self, observation: Mapping[str, Any], believed: Believed) -> None:
        """Say once when the arm begins to be held, and once when it was moved."""
        if not believed.is_believed.all() and not self._is_held:
            shown = self._shown(observation, ~believed.is_believed)
            _log.warning("The arm is held: its motors show what cannot be, %s.", shown)
        if believed.has_jumped.any() and not self._is_displaced:
            shown = self._shown(observation, believed.has_jumped)
            _log.warning("The arm was moved, and what is commanded follows it: %s.", shown)

    def _shown(self, observation: Mapping[str, Any], chosen: NDArray[np.bool_]) -> str:
        """What the motors of chosen joints ``(n,)`` show."""
        keys = (key for key, is_chosen in zip(self.keys, chosen, strict=True) if is_chosen)
        return ", ".join(f"{key} at {float(observation[key]):.1f}°" for key in keys)
