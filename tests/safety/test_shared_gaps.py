"""Actuators that share a safety goal share what its gaps may close."""

from collections.abc import Callable, Mapping

import pytest
import torch
from torch import Tensor, nn

from aicon_torch import (
    Actuator,
    Affine,
    Deterministic,
    Goal,
    GraphError,
    KalmanFilter,
    Measurement,
    Policy,
    Sensor,
    WorldModel,
)
from aicon_torch.dampers import VelocityDampers

ROOM = 1.0
"""What is between two carriages at first, m."""


def place(name: str, directly: bool) -> KalmanFilter | Deterministic:
    """Where a carriage is, as a filter knows it or as it is read."""
    if directly:
        return Deterministic(name, Affine(**{f"z_{name}": 1.0, f"v_{name}": "dt"}))
    return KalmanFilter(
        name,
        f"P_{name}",
        predict=Affine(**{name: 1.0, f"v_{name}": "dt"}),
        noise=1e-6,
        initial=((0.0,), 1.0),
        correct=[Measurement(Affine(**{name: 1.0, f"z_{name}": -1.0}), noise=1e-4, size=1)],
    )


def between(left: Tensor, right: Tensor) -> Tensor:
    """How far two carriages that come towards each other are beyond where they meet, m."""
    return left[..., 0] + right[..., 0] - ROOM


class LeftOfTheMiddle(nn.Module):
    """The left carriage stays on its side, wherever the other one is; which may be noted."""

    def __init__(self, notes: Callable[[Tensor], Tensor] = torch.zeros_like) -> None:
        super().__init__()
        self.notes = notes

    def forward(self, left: Tensor, right: Tensor) -> Tensor:
        return left[..., 0] - ROOM / 2 + 0.0 * right[..., 0]

    def gaps(self, left: Tensor, right: Tensor) -> Tensor:
        return ROOM / 2 - left + self.notes(right)


def carriages(
    dt: float,
    braking: float,
    directly: bool = False,
    keeps: Callable[..., Tensor] = between,
) -> Policy:
    """Two of them, each of which wants to go 5 m."""
    names, dampers = ("left", "right"), VelocityDampers(braking=braking, escape=None)
    model = WorldModel(
        sensors={f"z_{name}": Sensor(1, "m") for name in names},
        actuators={f"v_{name}": Actuator(1, "m/s", limit=1.0, dampers=dampers) for name in names},
        estimators=[place(name, directly) for name in names],
        goals=[
            Goal("far_left", lambda left: (left[..., 0] - 5.0).abs()),
            Goal("far_right", lambda right: (right[..., 0] - 5.0).abs()),
            Goal("between", keeps, safety=True),
        ],
        dt=dt,
        dtype=torch.float64,
    )
    return Policy(model)


def gaps(policy: Policy, dt: float, holds: Mapping[str, bool]) -> list[float]:
    """What is between them in each of 60 steps; one that holds does not move as it is told."""
    at = {name: torch.zeros(1, dtype=torch.float64) for name in holds}
    memory, found = None, []
    for _ in range(60):
        seen = {f"z_{name}": place for name, place in at.items()}
        actions, memory = policy.predict(seen, memory)
        for name in at:
            at[name] = at[name] + (0.0 if holds[name] else dt) * actions[f"v_{name}"]
        found.append(ROOM - float(sum(at.values())))
    return found


@pytest.mark.parametrize("directly", [False, True])
@pytest.mark.parametrize(
    ("dt", "braking"),
    [
        (0.25, 0.3),
        pytest.param(0.1, 0.15, marks=pytest.mark.slow),
        pytest.param(0.1, 0.1, marks=pytest.mark.slow),
        (0.05, 0.02),
    ],
)
def test_two_carriages_do_not_meet(dt: float, braking: float, directly: bool) -> None:
    found = gaps(carriages(dt, braking, directly), dt, {"left": False, "right": False})
    assert min(found) > -1e-9
    assert found[-1] < 0.05  # and come near to each other


def test_they_do_not_meet_where_one_of_them_is_stuck() -> None:
    found = gaps(carriages(0.1, 0.15), 0.1, {"left": False, "right": True})
    assert min(found) > -1e-9
    assert found[-1] < 0.05


def test_gaps_that_read_one_of_two_bound_that_one_as_if_it_were_alone() -> None:
    def of_left(left: Tensor) -> Tensor:
        return left[..., 0] - ROOM / 2

    readings = {f"z_{name}": torch.tensor([0.4], dtype=torch.float64) for name in ("left", "right")}
    found, memory = carriages(0.1, 0.15, keeps=LeftOfTheMiddle()).predict(readings)
    expected, same = carriages(0.1, 0.15, keeps=of_left).predict(readings)
    assert 0.0 < found["v_left"] < 0.5 < found["v_right"]
    assert found == expected and memory.keys() == same.keys()


def test_gaps_that_read_the_other_one_without_a_gradient_are_refused() -> None:
    with pytest.raises(GraphError, match="'between': its gaps do not depend on .* 'v_right'"):
        carriages(0.1, 0.15, keeps=LeftOfTheMiddle(Tensor.detach))
