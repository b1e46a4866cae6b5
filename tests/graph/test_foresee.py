"""What a world model foresees of actions: values, and how costs depend on the actions there."""

import pytest
import torch
from _asserts import assert_equal_gradients
from _asserts.path_gradients import sums_over_paths
from _inputs import BATCHES, normal
from torch import Tensor

from aicon_torch import (
    EKF,
    Actuator,
    Affine,
    Deterministic,
    Goal,
    KalmanFilter,
    Measurement,
    Sensor,
    WorldModel,
)


def moving(*measured: Measurement) -> WorldModel:
    """A point that the action moves, a bent image of it, and two smooth costs."""

    def bent(x: Tensor) -> Tensor:
        return torch.sin(x) + 0.3 * x.flip(-1) ** 2

    def far(x: Tensor, y: Tensor) -> Tensor:
        return (x - 1.0).square().sum(-1) + (y.square().sum(-1) + 1.0).sqrt()

    def odd(y: Tensor, a: Tensor, P: Tensor) -> Tensor:
        return y.prod(-1) + 0.1 * a.square().sum(-1) + 0.01 * P.sum((-2, -1))

    point = KalmanFilter(
        "x",
        "P",
        predict=Affine(x=1.0, a=0.1),
        noise=0.1,
        initial=((0.3, -0.2), 1.0),
        correct=measured,
    )
    return WorldModel(
        sensors={"z": Sensor(2, "m")},
        actuators={"a": Actuator(2, "m/s", 2.0)},
        estimators=[point, Deterministic("y", bent)],
        goals=[Goal("far", far), Goal("odd", odd)],
        dt=0.1,
        dtype=torch.float64,
    )


def values_of(model: WorldModel, batch: tuple[int, ...]) -> dict[str, Tensor]:
    """Values after a step in which the point moved."""
    start = model.initial({"z": normal(*batch, 2)}, batch)
    return model.update(start | {"a": normal(*batch, 2, seed=1)})


MEASUREMENT = Measurement(Affine(x=1.0, z=-1.0), 0.1, size=2)


@pytest.mark.parametrize("batch", BATCHES, ids=str)
def test_without_readings_what_is_foreseen_is_the_next_update(batch: tuple[int, ...]) -> None:
    model = moving()
    values, action = values_of(model, batch), {"a": normal(*batch, 2, seed=2)}
    foreseen, _ = model.foresee(values, action)

    expected = model.update(values | action)
    assert foreseen.keys() == expected.keys()
    for name, value in foreseen.items():
        assert not value.requires_grad
        torch.testing.assert_close(value, expected[name])


def test_what_no_goal_and_no_path_needs_is_not_foreseen() -> None:
    point = EKF("x", "P", predict=Affine(x=1.0, a=0.1), noise=1e-3, initial=((0.0,), 1.0))
    image = Deterministic("y", lambda x: 2 * x)
    spread = Deterministic("deviation", lambda P: P.diagonal(dim1=-2, dim2=-1).sqrt())
    model = WorldModel(
        sensors={"z": Sensor(1, "m")},
        actuators={"a": Actuator(1, "m/s", 2.0)},
        estimators=[point, image, spread],
        goals=[Goal("near", lambda y: y.square().sum(-1))],
        dt=0.1,
        dtype=torch.float64,
    )
    values = model.update(model.initial({"z": normal(1)}, ()) | {"a": normal(1)})
    foreseen, _ = model.foresee(values, {"a": normal(1, seed=2)})
    assert values.keys() - foreseen.keys() == {"P", "deviation"}


def test_nothing_is_read() -> None:
    """The reading in the values has been taken already; it corrects nothing again."""
    model = moving(MEASUREMENT)
    values, action = values_of(model, (3,)), {"a": normal(3, 2, seed=2)}
    foreseen, _ = model.foresee(values, action)
    torch.testing.assert_close(foreseen["x"], values["x"] + 0.1 * action["a"])

    other, _ = model.foresee(values | {"z": 100.0 + values["z"]}, action)
    assert torch.equal(other["x"], foreseen["x"])


def test_the_values_that_go_in_stay_as_they_are() -> None:
    model = moving(MEASUREMENT)
    values = values_of(model, ())
    before = {name: value.clone() for name, value in values.items()}
    model.foresee(values, {"a": normal(2, seed=2)})
    assert all(torch.equal(values[name], value) for name, value in before.items())


def test_the_sum_over_paths_is_the_slope_of_the_costs_that_are_foreseen() -> None:
    """By central differences of the costs by the action."""
    model = moving(MEASUREMENT)
    values, action = values_of(model, ()), normal(2, seed=2)
    _, graphs = model.foresee(values, {"a": action})

    def cost(action: Tensor) -> Tensor:
        foreseen, _ = model.foresee(values, {"a": action})
        return torch.stack(list(model.costs(foreseen).values())).sum()

    shifts = 1e-5 * torch.eye(2, dtype=torch.float64)
    slopes = torch.stack([cost(action + shift) - cost(action - shift) for shift in shifts]) / 2e-5
    assert_equal_gradients(sums_over_paths(model, graphs), {"a": slopes}, rtol=1e-7)


def test_every_quantity_on_a_path_has_its_graph() -> None:
    model = moving(MEASUREMENT)
    _, graphs = model.foresee(values_of(model, ()), {"a": normal(2, seed=2)})
    assert set(graphs) == set(model.edges)
    for name, graph in graphs.items():
        assert len(graph.leaves) == len(model.edges[name])


def test_a_horizon_is_how_long_the_actions_act() -> None:
    """Functions read it as their time step."""

    def moved(x: Tensor, a: Tensor, dt: float) -> Tensor:
        return x + dt * a

    point = EKF("x", "P", predict=moved, noise=1e-3, initial=((0.0, 0.0), 1.0))
    model = WorldModel(
        sensors={"z": Sensor(2, "m")},
        actuators={"a": Actuator(2, "m/s", 2.0)},
        estimators=[point],
        goals=[Goal("far", lambda x: (x * x).sum(-1))],
        dt=0.1,
        dtype=torch.float64,
    )
    values, action = values_of(model, ()), {"a": normal(2, seed=2)}
    foreseen, _ = model.foresee(values, action, horizon=0.5)
    torch.testing.assert_close(foreseen["x"], values["x"] + 0.5 * action["a"])
