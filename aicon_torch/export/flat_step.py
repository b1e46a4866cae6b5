"""The control step as functions of flat tensors, each of which is traced once.

    start:    readings → memory                            an episode begins
    whole:    memory, readings → memory, commands          a step of one gradient
    begin:    memory, readings → values, descent           a step of many: estimate, ...
    descend:  memory, values, descent → descent            ... take K gradients, ...
    finish:   memory, values, descent → memory, commands   ... and act

Readings are those of the observation, NaN where there is none; then come the ages of those that
have one, and executed actions that are told.
"""

from collections.abc import Mapping

import torch
from torch import Tensor

from aicon_torch.control.memory import GOAL_FACTORS, STEPS, initial_memory
from aicon_torch.control.step import ControlStep
from aicon_torch.export.codegen import FlatFunction
from aicon_torch.export.layout import Layout
from aicon_torch.quantities import AGE
from aicon_torch.readings.observation import in_unit
from aicon_torch.resolution import Memory

COUNT = "count"
"""Name of the number of the next gradient, k = 1 … K, within a descent."""


class FlatStep:
    """A control step on flat tensors, for one robot.

    Args:
        step: The step.

    Attributes:
        readings: Layout of the readings.
        memory: Layout of the memory.
        commands: Layout of the commands.
        values: Layout of the values and costs within a step.
        descent: Layout of what changes with each gradient of a step.
    """

    def __init__(self, step: ControlStep) -> None:
        self.step, self.model = step, step.model
        self._lay_out()

    def functions(self) -> dict[str, tuple[FlatFunction, tuple[str, ...], tuple[str, ...]]]:
        """Every function with the names of its inputs and outputs."""
        start = {"start": (self.start, ("readings",), ("next",))}
        if self.step.law.iterations == 1:
            whole = (self, ("memory", "readings"), ("next", "commands"))
            return {**start, "whole": whole}

        inputs = ("memory", "values", "descent")
        return {
            **start,
            "begin": (self.begin, ("memory", "readings"), ("values", "descent")),
            "descend": (self.descend, inputs, ("lower",)),
            "finish": (self.finish, inputs, ("next", "commands")),
        }

    def examples(self) -> dict[str, Tensor]:
        """A tensor for every input, to trace with."""
        sizes = {
            "readings": self.readings.size,
            "memory": self.memory.size,
            "values": self.values.size,
            "descent": self.descent.size,
        }
        return {name: self.model.like.new_ones(size) for name, size in sizes.items()}

    def __call__(self, memory: Tensor, readings: Tensor) -> tuple[Tensor, Tensor]:
        """A step of any batch, without being traced."""
        known = self.memory.unpack(memory)
        return self._packed(*self.step(self._in_units(readings), known))

    def restarted(self, memory: Tensor, readings: Tensor) -> Tensor:
        """The memory begun anew, but for the factors of the goals."""
        (fresh,) = self.start(readings)
        goals = self.memory.entries[GOAL_FACTORS]
        fresh[..., goals.start : goals.stop] = memory[..., goals.start : goals.stop]
        return fresh

    def start(self, readings: Tensor) -> tuple[Tensor, ...]:
        """The memory before an episode's first step."""
        first = self.step.admit.first(self._in_units(readings))
        batch = tuple(readings.shape[:-1])
        fresh = initial_memory(self.step.backward, self.step.admit, first, batch)
        return (self.memory.pack(fresh, self.model.like),)

    def begin(self, memory: Tensor, readings: Tensor) -> tuple[Tensor, ...]:
        """The values after the new readings, the costs there, and where the descent begins."""
        known = self.memory.unpack(memory)
        values, costs = self.step.estimate(self._in_units(readings), known)
        descent = {
            COUNT: self.model.like.new_ones(()),
            **self.step.start(values, known[STEPS]),
            **{name: known[name] for name in self._resolved},
        }
        return self._work(values, costs), self.descent.pack(descent, self.model.like)

    def descend(self, memory: Tensor, values: Tensor, descent: Tensor) -> tuple[Tensor, ...]:
        """One gradient down."""
        known, so_far = self.memory.unpack(memory), self.descent.unpack(descent)
        estimates, costs = self._unpack_work(values)
        actions = {name: so_far[name] for name in self.model.actuators}
        actions, resolved = self.step.descend(estimates, costs, known, actions, so_far[COUNT])

        lower = {COUNT: so_far[COUNT] + 1, **actions, **resolved}
        return (self.descent.pack(lower, self.model.like),)

    def finish(self, memory: Tensor, values: Tensor, descent: Tensor) -> tuple[Tensor, ...]:
        """The memory after the step, and the commands."""
        known, so_far = self.memory.unpack(memory), self.descent.unpack(descent)
        estimates, _ = self._unpack_work(values)
        actions = {name: so_far[name] for name in self.model.actuators}
        resolved = {name: so_far[name] for name in self._resolved}
        return self._packed(*self.step.finish(estimates, known, actions, resolved))

    def blank(self) -> Tensor:
        """The memory before the first episode: nothing, and every goal switched on."""
        zeros = self.memory.unpack(self.model.like.new_zeros(self.memory.size))
        zeros[GOAL_FACTORS] = torch.ones_like(zeros[GOAL_FACTORS])
        return self.memory.pack(zeros, self.model.like)

    def _lay_out(self) -> None:
        """What lives where, found by taking a step."""
        self.readings = Layout.of(self._readings())
        readings = self._in_units(self.model.like.new_ones(self.readings.size))
        first = self.step.admit.first(readings)
        memory = initial_memory(self.step.backward, self.step.admit, first, ())
        self.memory = Layout.of(memory)

        values, costs = self.step.estimate(readings, memory)
        actions = self.step.start(values, memory[STEPS])
        count = self.model.like.new_ones(())
        actions, resolved = self.step.descend(values, costs, memory, actions, count)
        commands, _ = self.step.finish(values, memory, actions, resolved)

        self._estimates, self._costs = Layout.of(values), Layout.of(costs)
        self._resolved = tuple(resolved)
        self.values = Layout.of({**values, **{f"cost of {goal}": c for goal, c in costs.items()}})
        self.descent = Layout.of({COUNT: count, **actions, **resolved})
        self.commands = Layout.of(commands)

    def _readings(self) -> dict[str, Tensor]:
        """A reading of each sensor, its age if it has one, and each action that is told."""
        like, readings = self.model.like, {}
        for name, sensor in self.model.sensors.items():
            readings[name] = like.new_zeros(sensor.size)
        for name, sensor in self.model.sensors.items():
            if sensor.is_aged:
                readings[name + AGE] = like.new_zeros(())
        for name, actuator in self.model.actuators.items():
            if actuator.key is not None:
                readings[name] = like.new_zeros(actuator.size)
        return readings

    def _in_units(self, readings: Tensor) -> dict[str, Tensor]:
        """The readings in the graph's units, NaN where there is none."""
        converted = self.readings.unpack(readings)
        for name, sensor in self.model.sensors.items():
            converted[name] = in_unit(converted[name], sensor)
        return converted

    def _work(self, values: Mapping[str, Tensor], costs: Mapping[str, Tensor]) -> Tensor:
        like = self.model.like
        return torch.cat((self._estimates.pack(values, like), self._costs.pack(costs, like)))

    def _unpack_work(self, values: Tensor) -> tuple[dict[str, Tensor], dict[str, Tensor]]:
        size = self._estimates.size
        return self._estimates.unpack(values[:size]), self._costs.unpack(values[size:])

    def _packed(self, commands: Mapping[str, Tensor], memory: Memory) -> tuple[Tensor, Tensor]:
        like = self.model.like
        return self.memory.pack(memory, like), self.commands.pack(commands, like)
