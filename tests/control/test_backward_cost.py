"""The backward pass costs edges, not paths."""

from typing import Any

import pytest
import torch
from torch import Tensor

from aicon_torch import (
    Actuator,
    Deterministic,
    DirectDescent,
    Goal,
    Interconnection,
    NullspaceProjection,
    Policy,
    Resolution,
    Sensor,
    Sum,
    WorldModel,
)


def ladder(rungs: int) -> WorldModel:
    """Two rails; every rung crosses over, so that each doubles the number of paths."""

    def straight_and_across(rail: Tensor, other: Tensor) -> Tensor:
        return torch.sin(rail) + 0.5 * other

    def product(left: Tensor, right: Tensor) -> Tensor:
        return (left * right).sum(-1)

    estimators = [Deterministic("l0", lambda a: 0.9 * a), Deterministic("r0", lambda a: 1.1 * a)]
    for i in range(rungs):
        left, right = f"l{i}", f"r{i}"
        to_left = Interconnection(straight_and_across, inputs=[left, right])
        to_right = Interconnection(straight_and_across, inputs=[right, left])
        estimators += [Deterministic(f"l{i + 1}", to_left), Deterministic(f"r{i + 1}", to_right)]

    return WorldModel(
        sensors={"z": Sensor(1, "m")},
        actuators={"a": Actuator(2, "m")},
        estimators=estimators,
        goals=[Goal("g", Interconnection(product, inputs=[f"l{rungs}", f"r{rungs}"]))],
        dtype=torch.float64,
    )


class CountedGrad:
    """``torch.autograd.grad``, which counts its calls and their leaves."""

    def __init__(self) -> None:
        self.grad = torch.autograd.grad
        self.calls = 0
        self.leaves = 0

    def __call__(self, outputs: Any, inputs: Any, *args: Any, **options: Any) -> Any:
        self.calls += 1
        self.leaves += len(inputs) if isinstance(inputs, list | tuple) else 1
        return self.grad(outputs, inputs, *args, **options)


def cost_of_a_step(rungs: int, rule: Resolution, monkeypatch: pytest.MonkeyPatch) -> CountedGrad:
    policy = Policy(ladder(rungs), rule, DirectDescent(1.0))
    counted = CountedGrad()

    with monkeypatch.context() as patch:
        patch.setattr(torch.autograd, "grad", counted)
        policy.predict({"z": torch.zeros(1, dtype=torch.float64)})

    return counted


@pytest.mark.parametrize("rule", [Sum(), NullspaceProjection()], ids=["sum", "nullspace"])
def test_a_backward_pass_costs_edges_though_paths_double_with_every_rung(
    rule: Resolution, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls: dict[int, int] = {}

    for rungs in (6, 12, 24):
        assert len(ladder(rungs).paths()) == 2 ** (rungs + 1)

        cost = cost_of_a_step(rungs, rule, monkeypatch)
        edges = 4 * rungs + 4
        assert cost.leaves == edges
        assert cost.calls <= edges
        calls[rungs] = cost.calls

    assert calls[24] - calls[12] == 2 * (calls[12] - calls[6])
