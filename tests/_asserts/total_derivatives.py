"""Derivatives of a model as one function, by autograd and by central differences."""

from collections.abc import Mapping, Sequence

import torch
from torch import Tensor

from aicon_torch import WorldModel

Values = Mapping[str, Tensor]


def totals(model: WorldModel, values: Values, actions: Values) -> dict[str, Tensor]:
    """The derivative of the sum of all costs by the actions, of the model as one function."""
    leaves = {name: action.detach().clone().requires_grad_() for name, action in actions.items()}
    costs = model.end_to_end_costs(values, leaves)

    total = torch.stack([cost.sum() for cost in costs.values()]).sum()
    slopes = torch.autograd.grad(total, list(leaves.values()))
    return dict(zip(leaves, slopes, strict=True))


def numeric_totals(
    model: WorldModel,
    values: Values,
    actions: Values,
    goals: Sequence[str] | None = None,
    step: float = 1e-5,
) -> dict[str, Tensor]:
    """The same by central differences, without batch dimensions, for some goals.

    Nothing is differentiated.

    Around the values after a step, each quantity moves by what the model anticipates to change with
    the actions.
    """
    offsets = _offsets(model, values, actions)

    def cost(name: str, action: Tensor) -> Tensor:
        ahead = _anticipate(model, values, {**actions, name: action}, offsets)
        return torch.stack([ahead[goal] for goal in goals or model.goals]).sum()

    slopes: dict[str, Tensor] = {}
    for name, action in actions.items():
        shifts = step * torch.eye(action.shape[-1], dtype=action.dtype)
        rises = [cost(name, action + shift) - cost(name, action - shift) for shift in shifts]
        slopes[name] = torch.stack(rises) / (2 * step)

    return slopes


def _anticipate(
    model: WorldModel, values: Values, actions: Values, offsets: Values
) -> dict[str, Tensor]:
    """What the model expects of quantities and costs, each quantity shifted by its offset before it
    is read.
    """
    known = {**values, **actions}
    ahead: dict[str, Tensor] = {}

    for node in model.estimators:
        for name in node.outputs:
            if name in model.edges:
                ahead[name] = node(known, name).detach()

        known |= {
            name: ahead[name] + offsets.get(name, 0.0) for name in node.outputs if name in ahead
        }

    return ahead | {name: goal(known).detach() for name, goal in model.goals.items()}


def _offsets(model: WorldModel, values: Values, actions: Values) -> dict[str, Tensor]:
    """From what the model expects of each quantity to its value after the step.

    One after the other: the offset of each leaves those that read it at that value.
    """
    offsets: dict[str, Tensor] = {}

    for node in model.estimators:
        for name in node.outputs:
            if name in model.edges:
                offsets[name] = values[name] - _anticipate(model, values, actions, offsets)[name]

    return offsets


def assert_equal_gradients(first: Values, second: Values, rtol: float = 1e-10) -> None:
    """Gradients agree at every actuator, relative to the largest."""
    assert first.keys() == second.keys()
    scale = max(float(gradient.abs().max()) for gradient in second.values())

    for name in second:
        torch.testing.assert_close(
            first[name], second[name], rtol=rtol, atol=rtol * max(scale, 1e-6)
        )
