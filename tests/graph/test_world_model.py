"""World models run: steps, estimation alone, priors, precision, displaced costs."""

from typing import Any

import pytest
import torch
from _inputs import (
    DTYPES,
    MOVE,
    TRACK,
    Blueprint,
    actions,
    approach,
    built,
    graphs,
    in_motion,
    move,
    readings,
    tracked_point,
    tracking_model,
)
from hypothesis import given
from hypothesis import strategies as st
from torch import Tensor

from aicon_torch import EKF, Deterministic, Goal
from aicon_torch.interconnections import Values


@given(graphs(), st.sampled_from([(), (3,)]))
def test_estimation_alone_gives_the_same_values(
    blueprint: Blueprint, batch: tuple[int, ...]
) -> None:
    graph = built(blueprint)
    values = in_motion(graph, batch) | actions(graph, batch, 9) | readings(batch, 9)
    after = graph.update(values)
    local = graph.record(after)
    assert set(local) == set(graph.edges)

    alone = graph.update(values)

    for name in after:
        assert not after[name].requires_grad
        assert torch.equal(after[name], alone[name])
        if name in graph.owners:
            assert after[name].shape == (*batch, *graph.quantities[name].shape)


@given(graphs())
def test_the_uncut_model_stands_at_the_values_of_the_step(blueprint: Blueprint) -> None:
    graph = built(blueprint)
    values = in_motion(graph)

    leaves = {name: values[name].clone().requires_grad_() for name in graph.actuators}
    costs = graph.end_to_end_costs(values, leaves)

    for name, goal in graph.goals.items():
        torch.testing.assert_close(costs[name], goal(values))


def test_a_model_starts_at_rest_at_its_priors() -> None:
    def prior(z: Tensor) -> tuple[Tensor, Tensor]:
        return 2.0 * z, torch.diag_embed(z**2)

    shifted = Deterministic("x", lambda a: a + 1.0)
    graph = tracking_model(shifted, tracked_point(initial=prior, size=2))

    z = torch.tensor([[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]], dtype=torch.float64)
    values = graph.initial({"z": z}, (3,))

    assert not values["a"].any()
    assert torch.equal(values["p"], 2.0 * z)
    assert torch.equal(values["P"], torch.diag_embed(z**2))
    assert (values["x"] == 1.0).all()

    constant = tracking_model().initial({"z": z}, (3,))
    assert torch.equal(constant["p"], torch.tensor([1.0, 2.0], dtype=torch.float64).expand(3, 2))
    assert torch.equal(constant["P"], torch.eye(2, dtype=torch.float64).expand(3, 2, 2))


@pytest.mark.parametrize("dtype", DTYPES, ids=str)
def test_constants_follow_the_precision(dtype: torch.dtype) -> None:
    graph = tracking_model(dtype=dtype)
    start = graph.initial({"z": torch.zeros(2, dtype=dtype)}, ())
    after = graph.update(start)

    assert all(value.dtype == dtype for value in after.values())


@pytest.mark.parametrize("dt", [0.1, 0.5])
def test_dt_may_be_read_by_every_function(dt: float) -> None:
    graph = tracking_model(dt=dt)
    values = {**in_motion(graph), "a": torch.ones(2, dtype=torch.float64)}
    assert graph.update(values)["x"].tolist() == [dt, dt]


# --- displaced costs


def test_a_displaced_motion_moves_what_it_moves() -> None:
    """Had the robot not moved by s, the target would be at p + s; covariances stay as they are."""

    def cost(p: Tensor, P: Tensor) -> Tensor:
        return p.norm(dim=-1) + P.diagonal(dim1=-2, dim2=-1).sum(-1)

    motion = Deterministic("x", move, is_motion=True)
    graph = tracking_model(motion, TRACK, goals=[Goal("cost", cost)])

    values = in_motion(graph, (3,))
    shift = torch.tensor([0.3, -0.1], dtype=torch.float64).expand(3, 2)
    expected = cost(values["p"] + shift, values["P"])

    torch.testing.assert_close(graph.displaced_cost("cost", "x", -shift, values), expected)
    torch.testing.assert_close(graph.displaced_cost("cost", "p", shift, values), expected)


def test_an_estimator_may_update_itself_in_its_own_way() -> None:
    class Fixed(EKF):
        def update(self, values: Values) -> dict[str, Tensor]:
            updated = super().update(values)
            return {**updated, "p": torch.full_like(updated["p"], 7.0)}

    settings: dict[str, Any] = {"predict": approach, "noise": 0.1, "initial": ((1.0, 2.0), 1.0)}
    model = tracking_model(MOVE, Fixed("p", "P", **settings))
    values = model.initial({"z": torch.zeros(2, dtype=torch.float64)}, ())
    assert model.update(values)["p"].tolist() == [7.0, 7.0]
