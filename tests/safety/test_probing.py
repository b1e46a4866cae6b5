"""What a safety goal is like is found when the model is built: which gaps count."""

import pytest
import torch
from _inputs.walls import DT, drive, place, point_policy
from torch import Tensor, nn

from aicon_torch import (
    Actuator,
    Affine,
    Goal,
    GraphError,
    Interconnection,
    KalmanFilter,
    Measurement,
    Policy,
    Sensor,
    Shield,
    WorldModel,
)
from aicon_torch.parts import JointLimits, SquaredHinge


class Gaps(nn.Module):
    """A wall at x = 1, after some gaps that no action changes."""

    def __init__(self, still: int, most_gaps: int = 8) -> None:
        super().__init__()
        self.still, self.most_gaps = still, most_gaps

    def forward(self, x: Tensor) -> Tensor:
        return (-self.gaps(x)).clamp(min=0.0).sum(-1)

    def gaps(self, x: Tensor) -> Tensor:
        still = (0.0 * x[..., :1] - 0.5).expand(*x.shape[:-1], self.still)
        return torch.cat((still, 1.0 - x[..., :1] - 0.3 * x[..., 1:]), dim=-1)


def walled(cost: nn.Module) -> Policy:
    """It wants to go beyond what a safety goal allows."""
    return point_policy([Goal("wall", Interconnection(cost, inputs=["x"]), safety=True)])


def test_gaps_that_no_action_changes_crowd_out_none() -> None:
    way, _ = drive(walled(Gaps(still=12)), place(0.0, 0.0), place(3.0, 0.0), steps=60)
    assert (1.0 - way[..., 0] - 0.3 * way[..., 1]).min() > -1e-6


def test_a_goal_that_lets_no_gap_count_is_refused() -> None:
    with pytest.raises(GraphError, match=r"'wall'.*the 0 smallest"):
        walled(Gaps(still=0, most_gaps=0))


@pytest.mark.parametrize(
    "unit", [1e-3, 1e5, *(pytest.param(unit, marks=pytest.mark.slow) for unit in (1.0, 1e3))]
)
def test_a_gap_counts_in_whatever_unit_it_is(unit: float) -> None:
    wall = Goal("wall", lambda x: unit * (x[..., 0] + 0.3 * x[..., 1] - 1.0), safety=True)
    way, _ = drive(point_policy([wall]), place(0.0, 0.0), place(3.0, 0.0), steps=60)
    assert 0.9 < (way[..., 0] + 0.3 * way[..., 1]).max() < 1.0 + 1e-6


def test_a_cost_that_is_flat_where_nothing_is_violated_is_named() -> None:
    hinge = Goal("pillar", lambda x: (0.3 - x.norm(dim=-1)).clamp(min=0.0), safety=True)
    with pytest.warns(UserWarning, match=r"'pillar': its cost is 0 where nothing is violated"):
        point_policy([hinge])


def moved_by(name: str, action: str) -> KalmanFilter:
    """An estimate that changes as fast as another quantity says."""
    return KalmanFilter(
        name,
        f"P_{name}",
        predict=Affine(**{name: 1.0, action: "dt"}),
        noise=1e-6,
        initial=((0.0,), 1.0),
        correct=[Measurement(Affine(**{name: 1.0, f"z_{name}": -1.0}), 1e-6, size=1)],
    )


def test_an_acceleration_is_no_velocity() -> None:
    model = WorldModel(
        sensors={"z_x": Sensor(1, "m"), "z_u": Sensor(1, "m/s")},
        actuators={"a": Actuator(1, "m/s²", limit=1.0)},
        estimators=[moved_by("u", "a"), moved_by("x", "u")],
        goals=[
            Goal("wall", lambda x: x[..., 0] - 2.0, safety=True),
            Goal("far", lambda x: (x[..., 0] - 5.0).square()),
        ],
        dt=DT,
        dtype=torch.float64,
    )
    with pytest.raises(GraphError, match=r"'wall'.*'a' is back at rest"):
        Policy(model)
    with pytest.raises(GraphError, match=r"'wall'.*'a' is back at rest"):
        Shield(lambda _: torch.ones(1), model)


@pytest.mark.parametrize("dt", [0.02, 0.1, 0.3])
def test_a_step_longer_than_half_a_range_ends_before_the_other_stop(dt: float) -> None:
    stops = JointLimits([0.0], [0.04], SquaredHinge(0.001, 1.0))
    model = WorldModel(
        sensors={"z_x": Sensor(1, "m")},
        actuators={"v": Actuator(1, "m/s", limit=0.5)},
        estimators=[moved_by("x", "v")],
        goals=[Goal("stops", Interconnection(stops, inputs=["x"]), safety=True)],
        dt=dt,
        dtype=torch.float64,
    )
    shield = Shield(lambda _: torch.tensor([0.5]), model)
    action, _ = shield.predict({"z_x": torch.tensor([0.015])})
    assert 0.015 + dt * float(action) <= 0.04


def test_a_detour_keeps_to_the_constraints() -> None:
    def slow(a: Tensor) -> Tensor:
        fastest = a.norm(dim=-1, keepdim=True).clamp(min=1e-9)
        return a * (0.1 / fastest).clamp(max=1.0)

    pillar = Goal("pillar", lambda x: 0.5 - (x - place(1.5, 0.0)).norm(dim=-1), safety=True)
    policy = point_policy([pillar], constraints=[slow])
    way, memory = drive(policy, place(0.95, 0.0), place(3.0, 0.0), steps=200)
    assert memory["a/escape/escapes"] > 0
    assert (way.diff(dim=0).norm(dim=-1) / DT).max() < 0.1 + 1e-6
