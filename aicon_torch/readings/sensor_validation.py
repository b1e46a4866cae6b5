"""Validation of one sensor's readings: which are believed, and how old the last one is."""

from collections.abc import Mapping
from typing import NamedTuple, cast

import torch
from torch import Tensor

from aicon_torch.quantities import AGE, FROZEN, MISSED, PRESENT, RESTART, SILENCE, Actuator, Sensor
from aicon_torch.resolution import Memory

NEVER = 1e9
"""Age of a reading that never came, s."""

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
    """What came of a sensor; which case it is, is known row by row, ``(*B,)``.

    Attributes:
        reading: ``(*B, size)``.
        age: How old it is, ``(*B,)``, s.
        waited: How old the last one that was believed is, likewise.
        is_newer: Whether it was taken after that one.
        is_older: Whether before.
        is_frozen: Whether it repeats that one while it should not.
        was_frozen: Whether the last ones did.
    """

    reading: Tensor
    age: Tensor
    waited: Tensor
    is_newer: Tensor
    is_older: Tensor
    is_frozen: Tensor
    was_frozen: Tensor


class _Gate(NamedTuple):
    """What a rate limit says of an arrival.

    Attributes:
        is_believed: Whether it is the reading from now on, ``(*B,)``.
        is_plausible: Whether it is an older one that could have been, ``(*B,)``.
        remembered: The memory of the gate, by key.
    """

    is_believed: Tensor
    is_plausible: Tensor
    remembered: dict[str, Tensor]


class SensorValidation(NamedTuple):
    """Takes the readings of a sensor as they come, and says which of them are believed.

    ====================================================  ========  ===============================
    what comes                                            believed  what else is known then
    ====================================================  ========  ===============================
    nothing, or what cannot be                            no
    what repeats itself while its actuator acts           no        frozen, until one is believed
    the same one again                                    no
    one that is older than the last, and plausible        no        the silence ends
    a newer one, near the last one or those before it     yes       the silence ends
    a newer one that jumped farther than it can           no        refused; four in a row that
                                                                    agree are believed
    ====================================================  ========  ===============================

    Attributes:
        name: Name of the sensor.
        sensor: The sensor.
        actuator: That whose motion its readings must show, if one is.
        dt: Time step, s.
    """

    name: str
    sensor: Sensor
    actuator: Actuator | None
    dt: float

    def initial(self) -> Memory:
        """What is remembered besides the reading before the first, without batch dimensions."""
        name, sensor = self.name, self.sensor
        never = torch.tensor(NEVER, dtype=torch.float32)

        # Of every sensor: whether there was a reading, how old it is, and how many were missed.
        memory = {name + PRESENT: torch.tensor(False), name + AGE: never}
        memory[name + MISSED] = torch.tensor(0)

        # What its options ask for.
        if sensor.max_gap is not None:
            memory[name + SILENCE] = never
        if sensor.driven_by is not None:
            memory[name + FROZEN] = torch.tensor(False)
        if sensor.rate_limit is not None:
            memory[name + RESTART] = torch.tensor(False)
            memory[name + SEEN] = torch.zeros(sensor.size)
            memory[name + SEEN_AGE] = never
            memory[name + AGREED] = memory[name + REFUSED] = torch.tensor(0)
        return memory

    def __call__(
        self, readings: Mapping[str, Tensor], memory: Mapping[str, Tensor], elapsed: Tensor
    ) -> dict[str, Tensor]:
        """The reading, and what is known of it.

        Args:
            readings: The readings ``(*B, size)``, with NaN where there is none, and their ages.
            memory: The memory before the step.
            elapsed: How long the last step took, ``(*B,)``, s.
        """
        name, sensor = self.name, self.sensor

        # 1. Is there a new reading, and does it fit what came before?
        came = self._arrival(readings, memory, elapsed)
        gate = _Gate(came.is_newer, came.is_older, {})
        if sensor.rate_limit is not None:
            gate = self._gated(came, memory, elapsed)
        is_believed, known = gate.is_believed, gate.remembered

        # 2. Does it stand still though the robot moves, and for how long has it told nothing?
        if sensor.driven_by is not None:
            known[name + FROZEN] = (came.was_frozen | came.is_frozen) & ~is_believed
        if sensor.max_gap is not None:
            silence = (memory[name + SILENCE] + elapsed).clamp(max=NEVER)
            known[name + SILENCE] = torch.where(is_believed | gate.is_plausible, 0.0, silence)

        # 3. A reading that is not believed is replaced by the last one that was.
        age = torch.where(is_believed, came.age, came.waited).clamp(max=NEVER)
        return known | {
            name: torch.where(is_believed.unsqueeze(-1), came.reading, memory[name]),
            name + PRESENT: is_believed,
            name + AGE: age,
            name + MISSED: memory[name + MISSED] + ~is_believed,
        }

    def can_be(self, readings: Mapping[str, Tensor]) -> Tensor:
        """Whether there is a reading that the instrument can have meant, ``(*B,)``."""
        name, sensor = self.name, self.sensor
        can_be = readings[name].isfinite().all(-1)
        if name + AGE in readings:
            age = readings[name + AGE]
            can_be = can_be & (age >= 0) & (age < NEVER)
        if sensor.is_possible is not None:
            can_be = can_be & sensor.is_possible(readings[name])
        return can_be

    def _arrival(
        self, readings: Mapping[str, Tensor], memory: Mapping[str, Tensor], elapsed: Tensor
    ) -> _Arrival:
        """Which case a reading is, by all but its place, which the rate limit looks at."""
        name, sensor = self.name, self.sensor
        reading, waited = readings[name], memory[name + AGE] + elapsed
        age = readings.get(name + AGE, torch.zeros_like(waited))
        is_first, tick = memory[name + AGE] >= NEVER, 1e-3 * self.dt
        can_be = self.can_be(readings)

        # Does it repeat itself while it should change, and is not the same one again?
        was_frozen = memory.get(name + FROZEN, torch.zeros_like(can_be))
        is_frozen = was_frozen
        if sensor.driven_by is not None:
            is_another = ~is_first & ((age - waited).abs() > tick)
            is_frozen = is_another & self._is_frozen(reading, memory, was_frozen)
            can_be = can_be & ~is_frozen

        # Is it newer than the last?
        is_newer, is_older = can_be, torch.zeros_like(can_be)
        if sensor.is_aged:
            is_newer = can_be & (is_first | (age < waited - tick))
            is_older = can_be & (age > waited + tick)
        return _Arrival(reading, age, waited, is_newer, is_older, is_frozen, was_frozen)

    def _gated(self, came: _Arrival, memory: Mapping[str, Tensor], elapsed: Tensor) -> _Gate:
        """Whether a reading is where it can be.

        =====================================================  ========  ========
        reading                                                believed  refused
        =====================================================  ========  ========
        newer, near the last believed one, which is trusted    yes       0
        newer, the fourth in a row that agree with each other  yes       0
        newer, otherwise                                       no        one more
        older, far from the last believed one                  no        one more
        any other                                              no        as many
        =====================================================  ========  ========
        """
        name = self.name
        seen_waited = memory[name + SEEN_AGE] + elapsed
        refused, agreed = memory[name + REFUSED], memory[name + AGREED]

        # Is it near the last one that was believed, and does it agree with those just before it?
        is_near = self._is_near(came.reading, memory[name], came.waited - came.age)
        agrees = self._is_near(came.reading, memory[name + SEEN], seen_waited - came.age)
        in_a_row = torch.where(agrees, agreed + 1, 0)

        # Where much was refused, what was believed last may be the outlier; where it was frozen,
        # what differs may be one.
        is_trusted = is_near & (refused < PATIENCE) & ~came.was_frozen
        is_settled = in_a_row >= PATIENCE - 1
        is_believed = came.is_newer & (is_trusted | is_settled)
        is_refused = (came.is_newer & ~is_believed) | (came.is_older & ~is_near)

        more = torch.where(is_refused, (refused + 1).clamp(max=PATIENCE), refused)
        broken_off = torch.where(came.is_frozen, 0, agreed)
        remembered = {
            name + RESTART: came.is_newer & is_settled & ~is_near,
            name + SEEN: torch.where(
                came.is_newer.unsqueeze(-1), came.reading, memory[name + SEEN]
            ),
            name + SEEN_AGE: torch.where(came.is_newer, came.age, seen_waited).clamp(max=NEVER),
            name + AGREED: torch.where(came.is_newer, in_a_row.clamp(max=PATIENCE), broken_off),
            name + REFUSED: torch.where(is_believed, 0, more),
        }
        return _Gate(is_believed, came.is_older & is_trusted, remembered)

    def _is_near(self, reading: Tensor, other: Tensor, apart: Tensor) -> Tensor:
        """Whether two readings ``apart`` ``(*B,)`` s can be of one motion, ``(*B,)``.

        Each has noise of its own, however soon one follows the other. An angle goes the short way.
        """
        change = (reading - other) / reading.new_tensor(self.sensor.scale)
        period = self.sensor.period
        if period is not None:
            change = torch.remainder(change + period / 2, period) - period / 2
        farthest = cast(float, self.sensor.rate_limit) * apart.abs().clamp(min=self.dt)
        return change.abs().amax(-1) <= farthest

    def _is_frozen(
        self, reading: Tensor, memory: Mapping[str, Tensor], was_frozen: Tensor
    ) -> Tensor:
        """Whether the reading repeats the last one, and did so while the actuator acted."""
        # At rest anything may repeat itself.
        least = DRIVEN * cast(Actuator, self.actuator).limit_like(reading)
        acts = (memory[str(self.sensor.driven_by)].abs() > least).any(-1)

        repeats = (reading == memory[self.name]).all(-1)
        if self.sensor.range is not None:  # at its ends an instrument repeats itself
            scale = reading.new_tensor(self.sensor.scale)
            ends = [end * scale for end in self.sensor.range]
            inside = (reading > torch.minimum(*ends)) & (reading < torch.maximum(*ends))
            repeats = repeats & inside.all(-1)
        return repeats & (acts | was_frozen)
