"""The usual observation of one robot, read in a microsecond: arrays of real numbers, nothing else.

Whatever else an observation may be, such as a batch, tensors, ages or executed actions, is read and
checked by :func:`aicon_torch.readings.observation.read`.
"""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from aicon_torch.quantities import Actuator, Sensor

Array = NDArray[Any]


class _PlainReading(NamedTuple):
    """What is expected of one sensor; ``absent`` stands for it where it may be missing."""

    key: str
    shape: tuple[int]
    absent: Array | None


class PlainReadings:
    """Makes one flat array of an observation that tells no ages and no executed actions.

    Args:
        sensors: The sensors by name.
        actuators: The actuators by name.
        dtype: The precision of the flat array.
    """

    def __init__(
        self, sensors: Mapping[str, Sensor], actuators: Mapping[str, Actuator], dtype: Any
    ) -> None:
        self.dtype = dtype
        self._expected: list[_PlainReading] = []
        for name, sensor in sensors.items():
            absent = np.full(sensor.size, math.nan, dtype) if sensor.optional else None
            self._expected.append(_PlainReading(sensor.key_of(name), (sensor.size,), absent))

        # After the readings stand ages, then executed actions: as they are where none is reported.
        executed = [actuator for actuator in actuators.values() if actuator.key is not None]
        ages = [sensor.age for sensor in sensors.values() if sensor.is_aged]
        unknown = [math.nan] * sum(actuator.size for actuator in executed)
        self._untold = np.array([*ages, *unknown], dtype=dtype)

        # An observation with one of these tells them.
        self._telling = {sensor.age_key for sensor in sensors.values()}
        self._telling |= {actuator.key for actuator in executed}

    def of(self, observation: Mapping[str, Any]) -> Array | None:
        """The readings ``(n,)``; None if the observation is not a plain one."""
        if type(observation) is not dict or not self._telling.isdisjoint(observation):
            return None

        parts: list[Array] = []
        for key, shape, absent in self._expected:
            part = observation.get(key, absent)
            if type(part) is not np.ndarray or part.shape != shape or part.dtype.kind != "f":
                return None
            parts.append(part)

        # The only copy, and the change of precision with it.
        readings: Array = np.concatenate(
            [*parts, self._untold], dtype=self.dtype, casting="same_kind"
        )
        return readings
