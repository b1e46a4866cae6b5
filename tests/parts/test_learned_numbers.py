"""Numbers of parts that learn: what is computed of them is the same, and has a derivative."""

import copy
from collections.abc import Callable
from typing import Any

import pytest
import torch
from _inputs import normal
from torch import Tensor

from aicon_torch.differentiation import through_time
from aicon_torch.learned import make_learn
from aicon_torch.parts import (
    DifferentialDrive,
    Grasp,
    Gripper,
    Intrinsics,
    Landmark,
    MovingDiscs,
    MovingObstacle,
    Visibility,
)
from aicon_torch.parts.moving_obstacle import CollisionToCome, GapToCome, RangeBearingPrior

NOISES = (0.1, 0.1, 0.1, 0.1)
CAMERA = torch.tensor([1.0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, -0.5], dtype=torch.float64)
STEP = torch.tensor(0.1, dtype=torch.float64)
HAND = Gripper(narrowest=0.02, widest=0.12, speed=0.3)


def drive() -> DifferentialDrive:
    return DifferentialDrive(track=0.3)


def opened(gripper: Gripper) -> Tensor:
    rates = torch.tensor([[-1.0], [0.0], [1.0]], dtype=torch.float64)
    values = {"x_opening": 0.05 + 0 * rates, "jaw": rates, "dt": STEP}
    opening: Tensor = gripper(values, "x_opening")
    return opening


PARTS: list[tuple[Any, Callable[[Any], Tensor], str]] = [
    (MovingObstacle("x", "z", *NOISES), lambda part: part._drift(normal(3, 4)), "motion_noise"),
    (MovingObstacle("x", "z", *NOISES), lambda part: part._drift(normal(3, 4)), "acceleration"),
    (RangeBearingPrior(0.1, 0.1, 1.0), lambda part: part(normal(3, 2))[1], "speed"),
    (CollisionToCome(GapToCome(0.5, 2.0, 0.15), 0.1), lambda part: part(normal(3, 4)), "gap.ahead"),
    (
        Landmark("p", "z", 0.1, 0.1, wheels=drive()),
        lambda part: part._distance_ahead(normal(3, 2), torch.eye(2, dtype=torch.float64)),
        "wheels.track",
    ),
    (
        MovingDiscs(0.6, 0.1, 0.1, 0.1, 2.0),
        lambda part: part(normal(3, 2), normal(3, 8)),
        "horizon",
    ),
    (
        Visibility(Intrinsics(300, 160, 120, 320, 240), (1e-6, 1e-6, 1e-6), 30.0, 0.02),
        lambda part: part(0.1 * normal(3, 3), CAMERA.expand(3, 12)),
        "height",
    ),
    (
        Grasp(HAND, size=0.04, height=0.01, reach=0.05, clearance=0.06),
        lambda part: part.likelihood(0.1 * normal(3, 3), torch.full((3, 1), 0.1)),
        "clearance",
    ),
    (Gripper(narrowest=0.02, widest=0.12, speed=0.3), opened, "narrowest"),
    (Gripper(narrowest=0.02, widest=0.12, speed=0.3), opened, "widest"),
]


@pytest.mark.parametrize(("part", "call", "name"), PARTS)
def test_a_number_that_learns_counts_as_before(
    part: Any, call: Callable[[Any], Tensor], name: str
) -> None:
    expected = call(part)
    learner = copy.deepcopy(part)
    make_learn({"part": learner}, {f"part.{name}": None}, STEP)
    with through_time():
        found = call(learner)
    torch.testing.assert_close(found, expected, rtol=0, atol=0)


@pytest.mark.parametrize(("part", "call", "name"), PARTS[:5] + PARTS[6:7])
def test_what_is_computed_of_a_number_has_its_derivative(
    part: Any, call: Callable[[Any], Tensor], name: str
) -> None:
    learner = copy.deepcopy(part)
    (theta,) = make_learn({"part": learner}, {f"part.{name}": None}, STEP).values()
    with through_time():
        (slope,) = torch.autograd.grad(call(learner).sum(), theta)
    assert slope.isfinite() and slope != 0
