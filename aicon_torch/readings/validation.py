"""Admission: which readings are believed, and how old the last one is, sensor by sensor."""

from collections.abc import Mapping
from typing import NamedTuple, cast

import torch
from torch import Tensor

from aicon_torch.quantities import AGE, ANEW, FROZEN, MISSED, PRESENT, SILENCE, Actuator, Sensor
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


class _Arrival(NamedTuple):
    """A reading that came, and can be one.

    Attributes:
        reading: ``(*B, size)``.
        age: How old it is, ``(*B,)``, s.
        is_newer: Whether it was taken after the last one that was believed, ``(*B,)``.
        is_older: Whether before.
        is_frozen: Whether it repeats that one while it should not.
        was_frozen: Whether the last ones did.
    """

    reading: Tensor
    age: Tensor
    is_newer: Tensor
    is_older: Tensor
    is_frozen: Tensor
    was_frozen: Tensor


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
            if sensor.max_gap is not None:
                memory[name + SILENCE] = torch.tensor(NEVER, dtype=torch.float32)
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

        # There is one that can be, ...
        is_read = reading.isfinite().all(-1) & (age >= 0) & (age < NEVER)
        if sensor.is_possible is not None:
            is_read = is_read & sensor.is_possible(reading)

        # ... it does not repeat itself while it should change, unless it is the same one again, ...
        tick = 1e-3 * self.dt
        was_frozen = memory.get(name + FROZEN, torch.zeros_like(is_read))
        frozen = was_frozen
        if sensor.driven_by is not None:
            is_other = ~is_first & ((age - waited).abs() > tick)
            frozen = is_other & self._is_frozen(sensor, reading, last, memory, was_frozen)
            is_read = is_read & ~frozen

        # ... it is newer than the last, ...
        is_present, is_older = is_read, torch.zeros_like(is_read)
        if sensor.is_aged:
            is_present = is_read & (is_first | (age < waited - tick))
            is_older = is_read & (age > waited + tick)

        # ... and it has not jumped farther than it can.
        if sensor.rate_limit is not None:
            came = _Arrival(reading, age, is_present, is_older, frozen, was_frozen)
            compared, is_older = self._compared(name, sensor, came, memory, elapsed)
            is_present = is_present & (compared[name + REFUSED] == 0)
            admitted |= compared

        # What is frozen stays so until there is a reading; what is older says that some still come.
        if sensor.driven_by is not None:
            admitted[name + FROZEN] = (was_frozen | frozen) & ~is_present
        if sensor.max_gap is not None:
            silence = (memory[name + SILENCE] + elapsed).clamp(max=NEVER)
            admitted[name + SILENCE] = torch.where(is_present | is_older, 0.0, silence)

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
        came: _Arrival,
        memory: Mapping[str, Tensor],
        elapsed: Tensor,
    ) -> tuple[dict[str, Tensor], Tensor]:
        """Whether a reading is where it can be, and what is remembered in order to tell.

        Returns:
            What is remembered, and whether it is an older one that is plausible, ``(*B,)``.
        """
        waited, seen_waited = memory[name + AGE] + elapsed, memory[name + SEEN_AGE] + elapsed
        reading, age, is_newer = came.reading, came.age, came.is_newer
        refused = memory[name + REFUSED]

        # Does it agree with the last one that was believed, or with those just before it?
        is_near = self._is_near(sensor, reading, memory[name], waited - age)
        agrees = self._is_near(sensor, reading, memory[name + SEEN], seen_waited - age)
        agreed = torch.where(agrees, memory[name + AGREED] + 1, 0)

        # Where much was refused, what was believed last may be the outlier; where it was frozen,
        # what differs may be one.
        is_settled = agreed >= PATIENCE - 1
        is_trusted = is_near & (refused < PATIENCE) & ~came.was_frozen

        # What is no reading changes nothing; an older one may be an outlier as well.
        more = (refused + 1).clamp(max=PATIENCE)
        now = torch.where(came.is_older & ~is_near, more, refused)
        now = torch.where(is_newer, torch.where(is_trusted | is_settled, 0, more), now)
        in_a_row = torch.where(came.is_frozen, 0, memory[name + AGREED])
        remembered = {
            name + ANEW: is_newer & is_settled & ~is_near,
            name + SEEN: torch.where(is_newer.unsqueeze(-1), reading, memory[name + SEEN]),
            name + SEEN_AGE: torch.where(is_newer, age, seen_waited).clamp(max=NEVER),
            name + AGREED: torch.where(is_newer, agreed.clamp(max=PATIENCE), in_a_row),
            name + REFUSED: now,
        }
        return remembered, came.is_older & is_trusted

    def _is_near(self, sensor: Sensor, reading: Tensor, other: Tensor, apart: Tensor) -> Tensor:
        """Whether two readings ``apart`` ``(*B,)`` s can be of one motion, ``(*B,)``.

        Each has noise of its own, however soon one follows the other.
        """
        farthest = cast(float, sensor.rate_limit) * apart.abs().clamp(min=self.dt)
        return self._jump(sensor, reading, other) <= farthest

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
        was_frozen: Tensor,
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
        return repeats & (acts | was_frozen)
