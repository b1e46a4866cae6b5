"""Measurement validation: which readings of all sensors are believed, and what was executed."""

from collections.abc import Mapping
from typing import NamedTuple

import torch
from torch import Tensor

from aicon_torch.quantities import AGE, PRESENT, Actuator, Sensor
from aicon_torch.readings.sensor_validation import SensorValidation
from aicon_torch.resolution import Memory

BEGINS = "begins"
"""Key of the flag ``(*B,)`` of rows whose episode begins with the next reading that it needs."""

LONGEST = 10.0
"""The longest step in which a robot is taken to have moved as it was told, in time steps."""


class MeasurementValidation(NamedTuple):
    """Takes readings as they come, and says which of them are believed.

    Attributes:
        sensors: The sensors by name.
        actuators: The actuators by name.
        needed: Sensors without which an episode cannot begin.
        dt: Time step, s.
        clock: The sensor that tells how long the last step took, if one does.
    """

    sensors: dict[str, Sensor]
    actuators: dict[str, Actuator]
    needed: tuple[str, ...]
    dt: float
    clock: str | None = None

    def initial(self) -> Memory:
        """What is remembered besides readings before the first, without batch dimensions."""
        memory = {BEGINS: torch.tensor(True)}
        for validation in self._validations():
            memory |= validation.initial()
        return memory

    def _validations(self) -> list[SensorValidation]:
        """The validation of each sensor's readings."""
        found: list[SensorValidation] = []
        for name, sensor in self.sensors.items():
            actuator = None if sensor.driven_by is None else self.actuators[sensor.driven_by]
            found.append(SensorValidation(name, sensor, actuator, self.dt))
        return found

    def first(self, readings: Mapping[str, Tensor]) -> dict[str, Tensor]:
        """The readings ``(*B, size)`` from which estimates start; zero stands for none."""
        first: dict[str, Tensor] = {}
        for validation in self._validations():
            reading = readings[validation.name]
            can_be = validation.can_be(readings).unsqueeze(-1)
            first[validation.name] = torch.where(can_be, reading, 0.0)
        return first

    def __call__(
        self, readings: Mapping[str, Tensor], memory: Mapping[str, Tensor]
    ) -> dict[str, Tensor]:
        """The readings, the last ones where there are none, and what is known of each.

        Args:
            readings: The readings ``(*B, size)``, with NaN where there is none, and their ages.
            memory: The memory before the step.
        """
        # How long the last step took.
        known: dict[str, Tensor] = {}
        elapsed = self._elapsed(readings, memory)

        # What is read.
        for validation in self._validations():
            known |= validation(readings, memory, elapsed)
        if self.clock is not None:
            known[self.clock] = self._moving(elapsed).unsqueeze(-1)

        # What was executed, where that is reported; no action is beyond its limit.
        for name, actuator in self.actuators.items():
            if actuator.key is not None:
                is_reported = readings[name].isfinite().all(-1, keepdim=True)
                executed = actuator.clip(readings[name].nan_to_num(0.0))
                known[name] = torch.where(is_reported, executed, memory[name])

        # An episode begins with the first step that has what it needs.
        lacks = torch.zeros_like(memory[BEGINS])
        for name in self.needed:
            lacks = lacks | ~known[name + PRESENT]
        known[BEGINS] = memory[BEGINS] & lacks
        return known

    def _elapsed(self, readings: Mapping[str, Tensor], memory: Mapping[str, Tensor]) -> Tensor:
        """How long the last step took, ``(*B,)``, s: as the clock tells, or as it should."""
        usual = torch.full_like(memory[next(iter(self.sensors)) + AGE], self.dt)
        if self.clock is None:
            return usual
        reported = readings[self.clock].squeeze(-1)
        return torch.where(reported.isfinite() & (reported >= 0), reported, usual)

    def _moving(self, elapsed: Tensor) -> Tensor:
        """The part of it in which the robot is taken to have moved, ``(*B,)``, s.

        What a robot does while its control loop stalls is not known: the belief stays.
        """
        return torch.where(elapsed > LONGEST * self.dt, 0.0, elapsed)
