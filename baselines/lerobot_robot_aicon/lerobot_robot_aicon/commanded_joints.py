"""The joints of an arm as they were commanded last."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lerobot_robot_aicon.arm_options import ArmOptions


class CommandedJoints:
    """Where joints were sent last, between the radians of a description and a robot's motors.

    What moves next is computed for the joints *as they were commanded*, which servos follow with a
    lag; they run ahead of the true ones by the configured lead at most, so that an arm that is
    held, or pushed, is not left behind.

    Args:
        joints: Names of the description's joints.
        options: The motors that turn them, and the lead.

    Raises:
        ValueError: If an option names a joint that the description does not have.

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
        self._offsets = np.array([options.offsets.get(joint, 0.0) for joint in joints])
        self._signs = np.array([options.signs.get(joint, 1) for joint in joints])
        if not np.isin(self._signs, (-1, 1)).all():
            raise ValueError(f"signs={options.signs!r}: expected 1 or -1 for each joint.")
        self._lead = np.radians(options.lead)
        self._fps = options.fps
        self.reset()

    def reset(self) -> None:
        """Forget where they were sent."""
        self._commanded: NDArray[Any] | None = None

    def read(self, positions: Mapping[str, Any]) -> NDArray[Any]:
        """The joints ``(n,)``, rad, that motors show or are sent to, degrees.

        Raises:
            ValueError: If one is no finite number.
        """
        degrees = np.array([float(positions[key]) for key in self.keys])
        for key, angle in zip(self.keys, degrees, strict=True):
            if not np.isfinite(angle):
                raise ValueError(f"{key} is {angle}: expected a finite number, degrees.")
        return np.radians(self._signs * (degrees - self._offsets))

    def written(self, joints: NDArray[Any]) -> dict[str, float]:
        """What the motors call joints ``(n,)``, degrees."""
        degrees = self._signs * np.degrees(joints) + self._offsets
        return dict(zip(self.keys, degrees.tolist(), strict=True))

    def commanded(self, observation: Mapping[str, Any]) -> NDArray[Any]:
        """Where they were sent last ``(n,)``, rad, no further ahead than the lead."""
        measured = self.read(observation)
        last = measured if self._commanded is None else self._commanded
        return np.clip(last, measured - self._lead, measured + self._lead)

    def moved(self, commanded: NDArray[Any], velocity: Any) -> dict[str, float]:
        """Where the motors are sent next, degrees: a step of a velocity ``(n,)``, rad/s, on."""
        self._commanded = commanded + np.asarray(velocity) / self._fps
        return self.written(self._commanded)
