"""The stages of a control step as functions of flat tensors, each of which is traced once.

    start:    readings → memory                            an episode begins
    begin:    memory, readings → values, descent           a step: estimate, ...
    descend:  memory, values, descent → descent            ... take K gradients, ...
    finish:   memory, values, descent → memory, commands   ... and act

Readings are those of the observation, NaN where there is none; then come the ages of those that
have one, and executed actions that are reported.
"""

from collections.abc import Mapping

import torch
from torch import Tensor

from aicon_torch.control.memory import OUTLASTS_EPISODES
from aicon_torch.control.stages import Named, Stage, run
from aicon_torch.control.step import ControlStep
from aicon_torch.export.codegen import FlatFunction
from aicon_torch.export.layout import Layout
from aicon_torch.quantities import AGE
from aicon_torch.readings.observation import in_unit
from aicon_torch.readings.validation import BEGINS


class FlatStep:
    """A control step on flat tensors, for one robot.

    Args:
        step: The step.

    Attributes:
        stages: The beginning of an episode, and the stages of a step.
        layouts: The layout of each group of tensors that a stage takes or gives.
    """

    def __init__(self, step: ControlStep) -> None:
        self.step, self.model = step, step.model
        self.stages = (step.beginning, *step.stages)

        # What lives where, found by taking a step.
        readings = self._readings()
        self.layouts = {"readings": Layout.of(readings)}
        groups: dict[str, Named] = {"readings": self._in_units(readings)}
        for stage in self.stages:
            # Once instead of K times: the shapes do not change from gradient to gradient.
            groups = run([stage._replace(times=1)], groups)
            for name in stage.gives:
                self.layouts.setdefault(name, Layout.of(groups[name]))

    def function_of(self, stage: Stage) -> FlatFunction:
        """A stage as a function of one flat tensor for each group, to as many others."""

        def flat(*given: Tensor) -> tuple[Tensor, ...]:
            groups = map(self.unpack, stage.takes, given)
            return tuple(map(self.pack, stage.gives, stage.function(*groups)))

        return flat

    def examples(self) -> dict[str, Tensor]:
        """A flat tensor for every group, to trace with."""
        like = self.model.like
        return {name: like.new_ones(layout.size) for name, layout in self.layouts.items()}

    def pack(self, name: str, group: Named) -> Tensor:
        """A group as one flat tensor ``(*B, n)``."""
        return self.layouts[name].pack(group, self.model.like)

    def unpack(self, name: str, flat: Tensor) -> dict[str, Tensor]:
        """A group out of one flat tensor ``(*B, n)``; readings in the graph's units."""
        group = self.layouts[name].unpack(flat)
        return self._in_units(group) if name == "readings" else group

    def blank(self) -> Tensor:
        """The memory before the first episode, which has yet to begin: every goal switched on."""
        memory = self.unpack("memory", self.model.like.new_zeros(self.layouts["memory"].size))
        for key in (BEGINS, *OUTLASTS_EPISODES):
            memory[key] = torch.ones_like(memory[key])
        return self.pack("memory", memory)

    def _readings(self) -> dict[str, Tensor]:
        """A reading of each sensor, its age if it has one, and each action that is reported."""
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

    def _in_units(self, readings: Mapping[str, Tensor]) -> dict[str, Tensor]:
        """The readings in the graph's units, NaN where there is none."""
        converted = dict(readings)
        for name, sensor in self.model.sensors.items():
            converted[name] = in_unit(converted[name], sensor)
        return converted
