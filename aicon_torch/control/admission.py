"""Admission: which readings are believed, and how old the last one is, sensor by sensor."""

from collections.abc import Mapping
from typing import NamedTuple, cast

import torch
from torch import Tensor

from aicon_torch.quantities import AGE, ANEW, FROZEN, MISSED, PRESENT, Actuator, Sensor
from aicon_torch.resolution import Memory

BEGINS = "begins"
"""Key of the flag ``(*B,)`` of rows whose episode begins with the next reading that it needs."""

NEVER = 1e9
"""Age of a reading that never came, s."""

LONGEST = 10.0
"""The longest step in which a robot is taken to have moved as it was told, in time steps."""

DRIVEN = 0.005
"""Share of an actuator's limit from which on it counts as acting."""

SEEN, SEEN_AGE = ".seen", ".seen_age"
"""Suffixes of the last reading of a sensor with a rate limit, believed or not, and its age, s."""

AGREED, REFUSED = ".agreed", ".refused"
"""Suffixes of how many readings in a row agreed with the one before, and how many were refused."""

PATIENCE = 4
"""Readings that are refused until the last one that was believed may be what is wrong, and readings
in a row that agree, and so are believed."""


class Admission(NamedTuple):
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
        for name, sensor in self.sensors.items():
            memory[name + PRESENT] = torch.tensor(False)
            memory[name + AGE] = torch.tensor(NEVER, dtype=torch.float32)
            memory[name + MISSED] = torch.tensor(0)
            if sensor.driven_by is not None:
                memory[name + FROZEN] = torch.tensor(False)
            if sensor.rate_limit is not None:
                memory[name + ANEW] = torch.tensor(False)
                memory[name + SEEN] = torch.zeros(sensor.size)
                memory[name + SEEN_AGE] = torch.tensor(NEVER, dtype=torch.float32)
                memory[name + AGREED] = memory[name + REFUSED] = torch.tensor(0)
        return memory

    def first(self, readings: Mapping[str, Tensor]) -> dict[str, Tensor]:
        """The readings ``(*B, size)`` from which estimates start; zero stands for none."""
        first: dict[str, Tensor] = {}
        for name in self.sensors:
            is_present = readings[name].isfinite().all(-1, keepdim=True)
            first[name] = torch.where(is_present, readings[name], 0.0)
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
        admitted: dict[str, Tensor] = {}
        elapsed = self._elapsed(readings, memory)

        # What is read.
        for name, sensor in self.sensors.items():
            admitted |= self._admit(name, sensor, readings, memory, elapsed)
        if self.clock is not None:
            admitted[self.clock] = self._moving(elapsed).unsqueeze(-1)

        # What was executed, where that is told; no action is beyond its limit.
        for name, actuator in self.actuators.items():
            if actuator.key is not None:
                told = readings[name].isfinite().all(-1, keepdim=True)
                executed = actuator.clip(readings[name].nan_to_num(0.0))
                admitted[name] = torch.where(told, executed, memory[name])

        # An episode begins with the first step that has what it needs.
        lacks = torch.zeros_like(memory[BEGINS])
        for name in self.needed:
            lacks = lacks | ~admitted[name + PRESENT]
        admitted[BEGINS] = memory[BEGINS] & lacks
        return admitted

    def _elapsed(self, readings: Mapping[str, Tensor], memory: Mapping[str, Tensor]) -> Tensor:
        """How long the last step took, ``(*B,)``, s: as the clock tells, or as it should."""
        usual = torch.full_like(memory[next(iter(self.sensors)) + AGE], self.dt)
        if self.clock is None:
            return usual
        told = readings[self.clock].squeeze(-1)
        return torch.where(told.isfinite() & (told >= 0), told, usual)

    def _moving(self, elapsed: Tensor) -> Tensor:
        """For how much of that the robot is taken to have moved, ``(*B,)``, s.

        What a robot does while its control loop stalls is not known: the belief stays.
        """
        return torch.where(elapsed > LONGEST * self.dt, 0.0, elapsed)

    def _admit(
        self,
        name: str,
        sensor: Sensor,
        readings: Mapping[str, Tensor],
        memory: Mapping[str, Tensor],
        elapsed: Tensor,
    ) -> dict[str, Tensor]:
        """One sensor's reading, and what is known of it."""
        reading, last = readings[name], memory[name]
        waited = memory[name + AGE] + elapsed
        is_first = memory[name + AGE] >= NEVER
        age = readings.get(name + AGE, torch.zeros_like(waited))
        admitted: dict[str, Tensor] = {}

        # There is one that can be, it is newer than the last, ...
        is_present = reading.isfinite().all(-1)
        if sensor.is_possible is not None:
            is_present = is_present & sensor.is_possible(reading)
        if sensor.is_aged:
            is_new = (age >= 0) & (is_first | (age < waited - 1e-3 * self.dt))
            is_present = is_present & is_new & (age < NEVER)

        # ... it does not repeat itself while it should change, ...
        if sensor.driven_by is not None:
            frozen = self._is_frozen(sensor, reading, last, memory, name) & ~is_first
            is_present = is_present & ~frozen
            admitted[name + FROZEN] = frozen

        # ... and it has not jumped farther than it can.
        if sensor.rate_limit is not None:
            admitted |= self._compared(name, sensor, reading, is_present, memory, elapsed)
            is_present = is_present & (admitted[name + REFUSED] == 0)

        age = torch.where(is_present, age, waited).clamp(max=NEVER)
        admitted[name] = torch.where(is_present.unsqueeze(-1), reading, last)
        admitted[name + PRESENT] = is_present
        admitted[name + AGE] = age
        admitted[name + MISSED] = memory[name + MISSED] + ~is_present
        return admitted

    def _compared(
        self,
        name: str,
        sensor: Sensor,
        reading: Tensor,
        is_present: Tensor,
        memory: Mapping[str, Tensor],
        elapsed: Tensor,
    ) -> dict[str, Tensor]:
        """Whether a reading is where it can be, and what is remembered in order to tell."""
        limit = cast(float, sensor.rate_limit)
        waited, seen_waited = memory[name + AGE] + elapsed, memory[name + SEEN_AGE] + elapsed
        refused = memory[name + REFUSED]

        # Does it agree with the last one that was believed, or with those just before it?
        is_near = self._jump(sensor, reading, memory[name]) <= limit * waited
        agrees = self._jump(sensor, reading, memory[name + SEEN]) <= limit * seen_waited
        agreed = torch.where(agrees, memory[name + AGREED] + 1, 0)

        # Where much was refused, what was believed last may be the outlier.
        is_settled = agreed >= PATIENCE - 1
        is_believed = (is_near & (refused < PATIENCE)) | is_settled

        # What is no reading changes nothing.
        now = torch.where(is_believed, 0, (refused + 1).clamp(max=PATIENCE))
        return {
            name + ANEW: is_present & is_settled & ~is_near,
            name + SEEN: torch.where(is_present.unsqueeze(-1), reading, memory[name + SEEN]),
            name + SEEN_AGE: torch.where(is_present, 0.0, seen_waited).clamp(max=NEVER),
            name + AGREED: torch.where(
                is_present, agreed.clamp(max=PATIENCE), memory[name + AGREED]
            ),
            name + REFUSED: torch.where(is_present, now, refused),
        }

    @staticmethod
    def _jump(sensor: Sensor, reading: Tensor, last: Tensor) -> Tensor:
        """The largest change of a component since the last reading, ``(*B,)``, as it is read."""
        change = (reading - last) / reading.new_tensor(sensor.scale)
        if sensor.period is not None:
            change = torch.remainder(change + sensor.period / 2, sensor.period) - sensor.period / 2
        largest: Tensor = change.abs().amax(-1)
        return largest

    def _is_frozen(
        self,
        sensor: Sensor,
        reading: Tensor,
        last: Tensor,
        memory: Mapping[str, Tensor],
        name: str,
    ) -> Tensor:
        """Whether the reading repeats the last one, and did so while the actuator acted."""
        actuator = str(sensor.driven_by)
        least = DRIVEN * self.actuators[actuator].limit_like(reading)
        acts = (memory[actuator].abs() > least).any(-1)

        repeats = (reading == last).all(-1)
        if sensor.range is not None:  # at its ends an instrument repeats itself
            scale = reading.new_tensor(sensor.scale)
            low, high = sensor.range
            inside = (reading > low * scale) & (reading < high * scale)
            repeats = repeats & inside.all(-1)
        return repeats & (acts | memory[name + FROZEN])
