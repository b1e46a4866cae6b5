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

    Attributes:
        keys: The motors' keys in observations and actions: ``"elbow_flex.pos"``.
    """

    def __init__(self, joints: Sequence[str], options: ArmOptions) -> None:
        self.keys = [f"{options.motors.get(joint, joint)}.pos" for joint in joints]
        self._offsets = np.array([options.offsets.get(joint, 0.0) for joint in joints])
        self._lead = np.radians(options.lead)
        self._fps = options.fps
        self.reset()

    def reset(self) -> None:
        """Forget where they were sent."""
        self._commanded: NDArray[Any] | None = None

    def read(self, positions: Mapping[str, Any]) -> NDArray[Any]:
        """The joints ``(n,)``, rad, that motors show or are sent to, degrees."""
        degrees = np.array([float(positions[key]) for key in self.keys])
        return np.radians(degrees - self._offsets)

    def written(self, joints: NDArray[Any]) -> dict[str, float]:
        """What the motors call joints ``(n,)``, degrees."""
        degrees = np.degrees(joints) + self._offsets
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
