"""The actions that stand behind commands which somebody else sent."""

from typing import Any

import torch
from torch import Tensor

from aicon_torch import WorldModel
from aicon_torch.resolution import Memory


def actions_of(sent: Any, model: WorldModel, memory: Memory) -> dict[str, Tensor]:
    """Each actuator's action a (B, n), for whose command c(a) this was sent.

    a = (∂c/∂a)⁻¹ (sent - c(0)), which is exact where a command is affine in its action.

    Args:
        sent: The commands (B, n), by actuator; of a single actuator, alone.
        model: Whose actuators they are.
        memory: What was known when they were sent, of B episodes.
    """
    if not isinstance(sent, dict):
        sent = dict.fromkeys(model.actuators, sent)

    values, actions = model.values(memory), {}
    for name in model.actuators:
        target = torch.as_tensor(sent[name]).to(values[name])
        command = model.declaration.commands.get(name)
        actions[name] = target if command is None else _solved(command, name, values, target)
    return actions


def _solved(command: Any, name: str, values: dict[str, Tensor], target: Tensor) -> Tensor:
    """One step of Newton from rest, in every row."""

    def commands(action: Tensor) -> Tensor:
        sent: Tensor = command({**values, name: action})
        return sent

    # No row's command depends on another row's action, so that their sum has all derivatives.
    rest = torch.zeros_like(target)
    summed = torch.autograd.functional.jacobian(lambda a: commands(a).sum(0), rest)
    jacobian = summed.movedim(0, -2)  # (B, n, n)
    return torch.linalg.solve(jacobian, target - commands(rest))
