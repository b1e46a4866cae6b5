"""What comes nearer pushes nobody through what stands still, nor beyond a limit of the norm."""

import pytest
import torch
from _inputs import normal
from _inputs.random_numbers import BATCHES
from _inputs.safety_bounds import closing, random_bounds
from torch import Tensor

from aicon_torch import (
    Actuator,
    Affine,
    Goal,
    KalmanFilter,
    Measurement,
    Sensor,
    Shield,
    WorldModel,
)
from aicon_torch.dampers import VelocityDampers
from aicon_torch.parts import moving_point
from aicon_torch.safety import SafetyBounds, nearest_safe

DT, SPEED = 0.05, 0.8
FLOOR = torch.tensor([0.479, 0.878], dtype=torch.float64)
SOLVERS = [1, 12, None]


def among_coming(
    rows: int = 8, share: float = 0.5, seed: int = 0
) -> tuple[SafetyBounds, Tensor, Tensor]:
    """Bounds of which some stand still, a little missed, and others come: those, and how fast."""
    within = random_bounds(200, rows=rows, seed=seed)
    is_coming = normal(200, rows, seed=seed + 3).abs() < share
    coming = torch.where(is_coming, normal(200, rows, seed=seed + 4).abs(), 0.0)
    missed = torch.where(is_coming, coming, 1e-3)
    return within._replace(bounds=missed), coming, is_coming


@pytest.mark.parametrize("sweeps", SOLVERS)
def test_what_stands_still_is_never_approached_for_what_comes(sweeps: int | None) -> None:
    within, coming, is_coming = among_coming()
    nominal = 5 * normal(200, 4, seed=9)
    action, _ = nearest_safe(nominal, within, sweeps, coming=coming)

    speed = (within.slopes * action.unsqueeze(-2)).sum(-1)
    slack = 1e-3 * within.high.amax(-1, keepdim=True) * within.slopes.norm(dim=-1)
    assert (speed >= -slack)[~is_coming].all()


def test_what_comes_may_come_at_most_twice_as_fast() -> None:
    within, coming, is_coming = among_coming(share=2.0)
    action, _ = nearest_safe(5 * normal(200, 4, seed=9), within, None, coming=coming)
    speed = (within.slopes * action.unsqueeze(-2)).sum(-1)
    slack = 1e-3 * within.high.amax(-1, keepdim=True) * within.slopes.norm(dim=-1)
    assert (speed >= -coming - slack)[is_coming].all()


def follow(proposal: tuple[float, float], sweeps: int | None, noise: float = 0.0) -> list[float]:
    """How far a point stays above a floor, which stands still, while a ceiling comes down on it."""
    direction = FLOOR / FLOOR.norm()
    dampers = VelocityDampers(sweeps=sweeps)
    model = WorldModel(
        sensors={"z": Sensor(2, "m"), "z_w": Sensor(1, "m")},
        actuators={"v": Actuator(2, "m/s", limit=(1.0, 1.0), dampers=dampers)},
        estimators=[place(2), moving_point("w", "z_w", dt=DT, noise=1e-3, size=1)],
        goals=[
            Goal("floor", lambda x: -(x @ direction.to(x)), safety=True),
            Goal("ceiling", lambda x, w: x @ direction.to(x) - w[..., 0], safety=True),
        ],
        dt=DT,
        dtype=torch.float64,
    )
    shield = Shield(lambda _: torch.tensor(proposal, dtype=torch.float64), model, goes_around=False)

    at, ceiling = 0.5 * direction, torch.tensor([1.5], dtype=torch.float64)
    state, found = None, []
    for step in range(70):
        seen = {"z": at + noise * normal(2, seed=step), "z_w": ceiling}
        action, state = shield.predict(seen, state)
        at, ceiling = at + DT * action, ceiling - DT * SPEED
        found.append(float(at @ direction))
    return found


def place(size: int) -> KalmanFilter:
    """Where a point is, as it is read."""
    return KalmanFilter(
        "x",
        "P",
        predict=Affine(x=1.0, v="dt"),
        noise=1e-6,
        initial=([0.5] * size, 1.0),
        correct=[Measurement(Affine(x=1.0, z=-1.0), noise=1e-6, size=size)],
    )


@pytest.mark.parametrize(
    ("sweeps", "noise"),
    [
        (12, 1e-3),
        (None, 1e-3),
        pytest.param(12, 0.0, marks=pytest.mark.slow),
        pytest.param(None, 0.0, marks=pytest.mark.slow),
    ],
)
def test_a_ceiling_that_comes_down_pushes_nobody_through_the_floor(
    sweeps: int | None, noise: float
) -> None:
    assert min(follow((0.5, -0.9), sweeps, noise)) > -3.0 * noise - 1e-3


@pytest.mark.parametrize("order", [1, -1])
def test_of_two_sides_of_a_box_the_one_that_stands_still_is_kept(order: int) -> None:
    goals = [
        Goal("ceiling", lambda x: x[..., 0] - 1.0, safety=True),
        Goal("rising", lambda x, w: w[..., 0] - x[..., 0], safety=True),
    ]
    model = WorldModel(
        sensors={"z": Sensor(1, "m"), "z_w": Sensor(1, "m")},
        actuators={"v": Actuator(1, "m/s", limit=(1.0,))},
        estimators=[place(1), moving_point("w", "z_w", dt=DT, noise=1e-3, size=1)],
        goals=goals[::order],
        dt=DT,
        dtype=torch.float64,
    )
    shield = Shield(lambda _: torch.zeros(1), model, goes_around=False)

    at, rising, state = torch.zeros(1), torch.tensor([-1.0]), None
    for _ in range(60):
        action, state = shield.predict({"z": at, "z_w": rising}, state)
        at, rising = at + DT * action, rising + DT * SPEED
    assert 0.9 < float(at) < 1.0


@pytest.mark.parametrize("batch", BATCHES)
@pytest.mark.parametrize("sweeps", SOLVERS)
def test_an_action_with_a_limited_norm_keeps_its_bounds(
    batch: tuple[int, ...], sweeps: int | None
) -> None:
    within = random_bounds(*batch, rows=3)
    within = within._replace(bounds=within.bounds.abs())
    free, _ = nearest_safe(torch.zeros(*batch, 4, dtype=torch.float64), within, 200)
    is_kept = (closing(free, within) > -1e-6).all(-1)
    longest = 1.05 * float(torch.where(is_kept, free.norm(dim=-1), 0.0).amax())

    nominal = 5 * normal(*batch, 4, seed=9)
    loose, _ = nearest_safe(nominal, within, 200 if sweeps else None)
    action, _ = nearest_safe(nominal, within, 200 if sweeps else None, longest=longest)
    assert (action.norm(dim=-1) <= longest + 1e-9).all()
    worst = closing(action, within).amin(-1)
    assert (worst >= closing(loose, within).amin(-1).clamp(max=0.0) - 1e-3)[is_kept].all()


def test_a_wall_that_comes_is_dodged_by_the_length_that_is_left() -> None:
    within = SafetyBounds(
        torch.tensor([[1.0, 0.0]]), torch.tensor([0.8]), -torch.ones(2), torch.ones(2)
    )
    action, _ = nearest_safe(torch.tensor([0.0, 1.0]), within, 12, longest=1.0)
    torch.testing.assert_close(action, torch.tensor([0.8, 0.6]))
