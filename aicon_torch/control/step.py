"""One control step: a pure function from readings and memory to commands and memory."""

from collections.abc import Mapping

import torch
from torch import Tensor

from aicon_torch.control.action_law import ActionLaw
from aicon_torch.control.backward import BackwardPass
from aicon_torch.control.memory import GOAL_FACTORS, STEPS
from aicon_torch.graph import WorldModel
from aicon_torch.readings.validation import Admission
from aicon_torch.resolution import Memory
from aicon_torch.safety.bounds import safety_of
from aicon_torch.safety.watchdog import confidence, keep_finite, stay

Actions = dict[str, Tensor]
"""The action of each actuator, ``(*B, size)``."""


class ControlStep:
    """Estimate, then descend: pull the goals' gradients back, resolve conflicts, act.

    Args:
        model: The world model.
        backward: The backward pass of its goals.
        law: From the gradients to the action.
    """

    def __init__(self, model: WorldModel, backward: BackwardPass, law: ActionLaw) -> None:
        self.model, self.backward, self.law = model, backward, law
        needed = model.graph.first_readings
        self.admit = Admission(model.sensors, model.actuators, needed, model.dt, model.clock)
        self.safety = safety_of(model)

    @torch.enable_grad()
    def __call__(self, readings: Mapping[str, Tensor], memory: Memory) -> tuple[Actions, Memory]:
        """One step.

        Args:
            readings: The readings by sensor, ``(*B, size)``, with NaN where there are none.
            memory: The memory before the step.

        Returns:
            What to send to each actuator, ``(*B, size)``, and the memory.
        """
        # 1. Every estimator takes the last action and the new readings.
        values, costs = self.estimate(readings, memory)

        # 2. Descend, gradient by gradient.
        actions = self.start(values, memory[STEPS])
        resolved: Memory = {}
        for iteration in range(1, self.law.iterations + 1):
            count = self.model.like.new_tensor(iteration)
            actions, resolved = self.descend(values, costs, memory, actions, count)

        # 3. Act, within what limits the actuators.
        return self.finish(values, memory, actions, resolved)

    def estimate(
        self, readings: Mapping[str, Tensor], memory: Memory
    ) -> tuple[dict[str, Tensor], dict[str, Tensor]]:
        """The values after the new readings, and the cost of each goal there, ``(*B,)``."""
        admitted = self.admit(readings, memory)
        values = self.model.update(last_values(self.model, memory) | admitted)
        with torch.no_grad():
            return values, self.model.costs(values)

    def start(self, values: Mapping[str, Tensor], steps: Tensor) -> Actions:
        """Where the descent of each actuator begins, ``steps`` ``(*B,)`` after the episode did."""
        starts: Actions = {}
        for name, actuator in self.model.actuators.items():
            motions = self.model.dither(name, values)
            starts[name] = self.law.start(values[name], steps, actuator, motions)
        return starts

    @torch.enable_grad()
    def descend(
        self,
        values: Mapping[str, Tensor],
        costs: dict[str, Tensor],
        memory: Memory,
        actions: Actions,
        iteration: Tensor,
    ) -> tuple[Actions, Memory]:
        """One gradient down.

        Args:
            values: The values after the new readings.
            costs: The cost of each goal there, ``(*B,)``.
            memory: The memory before the step.
            actions: The action of each actuator so far.
            iteration: k = 1 … K, a scalar.

        Returns:
            The actions after it, and the new memory of every quantity where gradients meet.
        """
        # How values and costs depend on each other, here or where the actions lead.
        if self.law.foresees:
            _, graphs = self.model.foresee(values, actions, self.law.horizon)
        else:
            graphs = self.model.record(values)

        # From the goals to the actuators: resolve what meets, pull it back one edge (Eq. 1).
        gradients, resolved = self.backward(graphs, values, memory, memory[GOAL_FACTORS], costs)

        descended: Actions = {}
        for name, actuator in self.model.actuators.items():
            action = self.law.descend(actions[name], gradients[name], iteration, actuator)
            if self.law.foresees:  # what is foreseen next is what would be executed
                action = self.model.constrain(name, {**values, name: action})
            descended[name] = action
        return descended, resolved

    def finish(
        self,
        values: Mapping[str, Tensor],
        memory: Memory,
        actions: Actions,
        resolved: Memory,
    ) -> tuple[Actions, Memory]:
        """What to send to each actuator, and the memory."""
        final, goal_factors = dict(values), memory[GOAL_FACTORS]
        remembered: Memory = {GOAL_FACTORS: goal_factors, STEPS: memory[STEPS] + 1}
        share = confidence(self.model.sensors, values)
        for name, actuator in self.model.actuators.items():
            final[name] = self.law.finish(actions[name], values[name], actuator, self.model.dt)
            final[name] = self.model.constrain(name, final)

            # Last come the safety goals, which nothing may violate, and then the watchdog.
            if name in self.safety:
                final[name], own = self.safety[name](values, final[name], memory, goal_factors)
                remembered |= own
            final[name] = actuator.clip(share * final[name])

        commands, sent = stay(self.model, self.model.commands(final), share, memory)
        new_memory = {**final, **resolved, **remembered, **sent}
        return keep_finite(self.model, commands, new_memory, memory)


def last_values(model: WorldModel, memory: Mapping[str, Tensor]) -> dict[str, Tensor]:
    """Estimates, readings and actions of the last step, out of the memory."""
    return {name: memory[name] for name in model.quantities}
