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
    # No row's command depends on another row's action, so that their sum has all derivatives.
    action = torch.zeros_like(target, requires_grad=True)
    with torch.enable_grad():
        sent: Tensor = command({**values, name: action})
        components = sent.sum(0).unbind()
        rows = [torch.autograd.grad(each, action, retain_graph=True)[0] for each in components]

    jacobian = torch.stack(rows, dim=-2)  # (B, n, n)
    solved: Tensor = torch.linalg.solve(jacobian, target - sent.detach())  # a number, no graph
    return solved
