"""One control step: a pure function from readings and memory to commands and memory."""

from collections.abc import Mapping

import torch
from torch import Tensor

from aicon_torch.control.action_law import ActionLaw
from aicon_torch.control.backward import BackwardPass
from aicon_torch.control.memory import GOAL_FACTORS
from aicon_torch.graph import WorldModel
from aicon_torch.resolution import Memory


class ControlStep:
    """Estimate, pull the goals' gradients back, resolve conflicts, descend.

    Args:
        model: The world model.
        backward: The backward pass of its goals.
        law: From the gradient to the action.
    """

    def __init__(self, model: WorldModel, backward: BackwardPass, law: ActionLaw) -> None:
        self.model, self.backward, self.law = model, backward, law

    @torch.enable_grad()
    def __call__(
        self, readings: Mapping[str, Tensor], memory: Memory
    ) -> tuple[dict[str, Tensor], Memory]:
        """One step.

        Args:
            readings: The readings by sensor, held where there are none, ``(*B, size)``.
            memory: The memory before the step.

        Returns:
            What to send to each actuator, ``(*B, size)``, and the memory.
        """
        # 1. Every estimator runs once, and records how its values depend on others.
        values, graphs = self.model.step(last_values(self.model, memory) | dict(readings))

        # 2. From the goals to the actuators: resolve what meets, pull it back one edge (Eq. 1).
        goal_factors = memory[GOAL_FACTORS]
        gradients, resolved = self.backward(graphs, values, memory, goal_factors)

        # 3. Descend, within what limits the actuators.
        for name, actuator in self.model.actuators.items():
            values[name] = self.law(gradients[name], values[name], actuator, self.model.dt)
            values[name] = self.model.constrain(name, values)

        return self.model.commands(values), {**values, **resolved, GOAL_FACTORS: goal_factors}


def last_values(model: WorldModel, memory: Mapping[str, Tensor]) -> dict[str, Tensor]:
    """Estimates, readings and actions of the last step, out of the memory."""
    return {name: memory[name] for name in model.quantities}
