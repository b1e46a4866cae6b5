"""The backward pass costs edges, not paths."""

from typing import Any

import pytest
import torch
from torch import Tensor

from aicon_torch import (
    ActionLaw,
    Actuator,
    Deterministic,
    Exploration,
    Goal,
    Interconnection,
    NullspaceProjection,
    Policy,
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


@pytest.mark.parametrize(
    "rule", [Sum(), NullspaceProjection(exploration=Exploration())], ids=["sum", "nullspace"]
)
def test_a_sweep_costs_edges_though_paths_double_with_every_rung(
    rule: Sum | NullspaceProjection, monkeypatch: pytest.MonkeyPatch
) -> None:
    pulls: dict[int, int] = {}
    leaves: dict[int, int] = {}
    original = torch.autograd.grad

    for rungs in (6, 12, 24):
        model = ladder(rungs)
        assert len(model.paths()) == 2 ** (rungs + 1)

        policy = Policy(model, rule, ActionLaw(1.0))
        counted: list[int] = []

        def count(
            outputs: Any, inputs: Any, *args: Any, counted: list[int] = counted, **kwargs: Any
        ) -> Any:
            counted.append(len(inputs) if isinstance(inputs, list | tuple) else 1)
            return original(outputs, inputs, *args, **kwargs)

        with monkeypatch.context() as patch:
            patch.setattr(torch.autograd, "grad", count)
            policy.predict({"z": torch.zeros(1, dtype=torch.float64)})

        pulls[rungs], leaves[rungs] = len(counted), sum(counted)

    edges = {rungs: 4 * rungs + 4 for rungs in pulls}
    assert leaves == edges
    assert all(pulls[rungs] <= edges[rungs] for rungs in pulls)
    assert pulls[24] - pulls[12] == 2 * (pulls[12] - pulls[6])
