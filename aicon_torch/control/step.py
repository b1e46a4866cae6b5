"""One control step: a pure function from readings and memory to commands and memory."""

from collections.abc import Mapping

import torch
from torch import Tensor

from aicon_torch.control.action_law import ActionLaw
from aicon_torch.control.backward import BackwardPass
from aicon_torch.control.memory import (
    GOAL_FACTORS,
    STEPS,
    STEPS_AT_MOST,
    initial_memory,
    lasting,
    restart_rows,
)
from aicon_torch.control.stages import Named, Stage, run
from aicon_torch.differentiation import values_only
from aicon_torch.graph import WorldModel
from aicon_torch.readings.validation import BEGINS, MeasurementValidation
from aicon_torch.resolution import Memory
from aicon_torch.safety.bounds import safety_of
from aicon_torch.safety.watchdog import confidence, keep_finite, stay

Actions = dict[str, Tensor]
"""The action of each actuator, ``(*B, size)``."""

COUNT = ".count"
"""Key of the number of the next gradient, k = 1 … K, within a descent."""


class ControlStep:
    """Estimate, then descend: pull the goals' gradients back, resolve conflicts, act.

    Its stages pass on *values*, which are those of all quantities, the cost of each goal and
    ``dt``, and the *descent*: the actions so far, and what is remembered where gradients meet.

    Args:
        model: The world model.
        backward: The backward pass of its goals.
        law: From the gradients to the action.
    """

    def __init__(self, model: WorldModel, backward: BackwardPass, law: ActionLaw) -> None:
        self.model, self.backward, self.law = model, backward, law
        needed = model.graph.first_readings
        self.validate = MeasurementValidation(
            model.sensors, model.actuators, needed, model.dt, model.clock
        )
        self.safety = safety_of(model)

    @property
    def stages(self) -> tuple[Stage, ...]:
        """What a step does, one after the other."""
        known = ("memory", "values", "descent")
        return (
            # 1. Every estimator takes the last action and the new readings.
            Stage("begin", self.begin, ("memory", "readings"), ("values", "descent")),
            # 2. Descend, gradient by gradient.
            Stage("descend", self.descend, known, ("descent",), times=self.law.iterations),
            # 3. Act, within what limits the actuators.
            Stage("finish", self.finish, known, ("memory", "commands")),
        )

    @property
    def beginning(self) -> Stage:
        """What comes before the first step of an episode."""
        return Stage("start", self.start, ("readings",), ("memory",))

    def __call__(self, readings: Named, memory: Memory) -> tuple[Actions, Memory]:
        """One step.

        Args:
            readings: The readings by sensor, ``(*B, size)``, with NaN where there are none.
            memory: The memory before the step.

        Returns:
            What to send to each actuator, ``(*B, size)``, and the memory.
        """
        after = run(self.stages, {"memory": memory, "readings": readings})
        return dict(after["commands"]), dict(after["memory"])

    def start(self, readings: Named) -> tuple[Memory]:
        """The memory before an episode's first step."""
        batch = tuple(readings[next(iter(self.model.sensors))].shape[:-1])
        return (initial_memory(self.backward, self.validate, self.validate.first(readings), batch),)

    def restarted(self, memory: Memory, readings: Named, starts: Tensor | None = None) -> Memory:
        """The memory, begun anew in rows ``(*B,)`` that start an episode, or wait to begin one."""
        starts = memory[BEGINS] if starts is None else starts | memory[BEGINS]
        if starts.device.type == "cpu" and not starts.any():  # elsewhere this would wait
            return memory
        (fresh,) = self.start(readings)
        return restart_rows(memory, fresh, starts)

    def begin(self, memory: Memory, readings: Named) -> tuple[Named, Named]:
        """The values after the new readings, and where the descent begins."""
        values = self.estimate(memory, readings)
        values.update(values_only(self.model.followed_costs)(values))

        # Where the law begins, the number of the next gradient, and what the last ones have left.
        descent = {COUNT: self.model.like.new_ones(())}
        for name, actuator in self.model.actuators.items():
            motions = self.model.dither(name, values)
            descent[name] = self.law.start(values[name], memory[STEPS], actuator, motions)
        return values, {**descent, **{key: memory[key] for key in self.backward.keys}}

    def estimate(
        self, memory: Memory, readings: Named, executed: Mapping[str, Tensor] | None = None
    ) -> dict[str, Tensor]:
        """The values after the new readings, and after actions that somebody else executed.

        A reading that is NaN ends here: its last one takes its place and is marked absent, so that
        corrections skip it, and the watchdog slows the action down as it ages.
        """
        validated = self.validate(readings, memory)
        return self.model.update({**self.model.values(memory), **validated, **(executed or {})})

    @torch.enable_grad()
    def descend(self, memory: Memory, values: Named, descent: Named) -> tuple[Named]:
        """One gradient down: the actions after it, and the new memory where gradients meet."""
        # How values and costs depend on each other, here or where the actions lead.
        if self.law.foresees:
            actions = {name: descent[name] for name in self.model.actuators}
            _, graphs = self.model.foresee(values, actions, self.law.horizon)
        else:
            graphs = self.model.record(values)

        # From the goals to the actuators: resolve what meets, pull it back one edge (Eq. 1).
        gradients, resolved = self.backward(graphs, values, memory, memory[GOAL_FACTORS])

        # Eq. 2: one step down what arrived at each actuator.
        lower = {COUNT: descent[COUNT] + 1, **resolved}
        for name, actuator in self.model.actuators.items():
            action = self.law.descend(descent[name], gradients[name], descent[COUNT], actuator)
            if self.law.foresees:  # what is foreseen next is what would be executed
                action = self.model.constrain(name, {**values, name: action})
            lower[name] = action
        return (lower,)

    @values_only
    def finish(self, memory: Memory, values: Named, descent: Named) -> tuple[Memory, Actions]:
        """The memory, and what to send to each actuator."""
        # What the last gradient of the descent has left is what is remembered.
        final, goal_factors = dict(values), memory[GOAL_FACTORS].clone()
        remembered: Memory = {
            GOAL_FACTORS: goal_factors,
            STEPS: (memory[STEPS] + 1) % STEPS_AT_MOST,
        }
        remembered |= {key: descent[key] for key in self.backward.keys}

        # From 1 to 0 as readings grow old; an action is executed by this share.
        share = confidence(self.model.sensors, values)
        for name, actuator in self.model.actuators.items():
            final[name] = self.law.finish(descent[name], values[name], actuator, self.model.dt)
            final[name] = self.model.constrain(name, final)

            # Last come the safety goals, which nothing may violate, and then the watchdog.
            if name in self.safety:
                final[name], own = self.safety[name](values, final[name], memory, goal_factors)
                remembered |= own
            final[name] = actuator.clip(share * final[name])

        # Rows at rest are sent their last command again, and only what is finite is sent at all.
        commands, sent = stay(self.model, self.model.commands(final), share, memory)
        new_memory = {**lasting(self.model, final), **remembered, **sent}
        commands, new_memory = keep_finite(self.model, commands, new_memory, memory)
        return new_memory, commands
