"""A clearance with its direction: how it slides along a wall, and its residuals."""

import math
from typing import Any

import pytest
import torch
from _inputs import normal
from torch import Tensor

from aicon_torch import Interconnection, OptionError
from aicon_torch.parts import (
    Clearance,
    ClearanceLimits,
    CollisionLikelihood,
    direction_residual,
    range_residual,
    slide,
    slide_jacobian,
    unit_gradient_jacobian,
    unit_gradient_residual,
)


def at(*components: float) -> Tensor:
    return torch.tensor(components, dtype=torch.float64)


def test_along_a_wall_the_clearance_is_what_it_was_and_towards_it_less() -> None:
    """A wall to the right: ∇d points to the left."""
    before = at(0.5, -1.0, 0.0)
    assert slide(before, at(0.0, 0.2)).tolist() == [0.5, -1.0, 0.0]
    assert slide(before, at(0.2, 0.0)).tolist() == pytest.approx([0.3, -1.0, 0.0])


@pytest.mark.parametrize("seed", range(3))
def test_the_jacobians_are_the_derivatives(seed: int) -> None:
    x_obs, x_rob = normal(3, seed=seed), normal(2, seed=seed + 10)
    moved = Interconnection(slide, x_obs=slide_jacobian)
    moved.verify({"x_obs": x_obs, "x_rob": x_rob}, 3)
    unit = Interconnection(unit_gradient_residual, x_obs=unit_gradient_jacobian)
    unit.verify({"x_obs": x_obs}, 1)


def test_the_residuals_are_zero_where_the_readings_agree() -> None:
    x_obs = at(0.4, 0.6, 0.8)
    opposite = at(math.atan2(-0.8, -0.6))
    residuals = (
        range_residual().double()({"x_obs": x_obs, "z_obs": at(0.4)}),
        unit_gradient_residual(x_obs),
        direction_residual(x_obs, opposite),
    )
    for residual in residuals:
        torch.testing.assert_close(residual, torch.zeros_like(residual), rtol=0, atol=1e-12)


def test_without_a_direction_the_unit_gradient_has_no_slope() -> None:
    assert unit_gradient_jacobian(at(0.4, 0.0, 0.0)).tolist() == [[0.0, 0.0, 0.0]]


def test_the_prior_is_the_first_reading_in_any_direction() -> None:
    walls = Clearance("x_obs", "z_obs", noise=0.01, motion_noise=0.001, dt=0.05)
    mean, covariance = walls.estimator().initial({"z_obs": at(0.7)}).values()
    assert mean.tolist() == [0.7, 0.0, 0.0]
    assert covariance.diagonal().tolist() == pytest.approx([1e-4, 0.5, 0.5])


def test_a_collision_is_certain_at_contact_and_falls_with_the_clearance() -> None:
    clearances = torch.stack([at(0.04, 1.0, 0.0), at(0.0, 0.0, 1.0)])
    found = CollisionLikelihood(0.04)(clearances).tolist()
    assert found == pytest.approx([math.exp(-1.0), 1.0])


def test_a_clearance_under_other_names_finds_the_direction_of_a_wall() -> None:
    """A wall to the right at 1 m, felt along a zigzag."""
    wall = Clearance("x_wall", "z_wall", noise=0.01, motion_noise=1e-3, dt=0.05, motion="moved")
    found, left = felt(wall, [at(0.02, 0.02), at(-0.02, 0.02)] * 40)
    torch.testing.assert_close(found["x_wall"], at(left, -1.0, 0.0), atol=0.1, rtol=0.0)

    likelihood = wall.collision_likelihood(length=0.5)(found)
    torch.testing.assert_close(likelihood, CollisionLikelihood(0.5)(found["x_wall"]))


def test_a_direction_that_is_read_is_known_at_once() -> None:
    wall = Clearance(
        "x_wall",
        "z_wall",
        noise=0.01,
        motion_noise=1e-3,
        dt=0.05,
        direction="z_side",
        motion="moved",
    )
    found, _ = felt(wall, [at(0.0, 0.0)])
    torch.testing.assert_close(found["x_wall"][1:], at(-1.0, 0.0), atol=0.01, rtol=0.0)


def test_limits_near_an_obstacle_are_wired_to_its_names() -> None:
    wall = Clearance("x_wall", "z_wall", noise=0.01, motion_noise=0.0, dt=0.05)
    limits = ClearanceLimits(time=0.5, margin=0.04, slowest=0.05)
    belief = {"x_wall": at(0.1, -1.0, 0.0), "P_wall": 1e-8 * torch.eye(3, dtype=torch.float64)}
    allowed = wall.limits(limits)({"a": at(0.5, 0.0), **belief})
    torch.testing.assert_close(allowed, limits(at(0.5, 0.0), belief["x_wall"], belief["P_wall"]))


def test_the_older_the_reading_and_the_larger_an_offset_the_slower() -> None:
    """‖a‖ ≤ (d − b)/(τ + t) where the belief is certain."""
    belief = at(0.2, -1.0, 0.0), torch.zeros(3, 3, dtype=torch.float64)
    limits = ClearanceLimits(time=0.5, margin=0.0, slowest=0.05, offset=0.05)
    for age in (0.0, 0.1, 0.25):
        speed = limits(at(0.0, 0.9), *belief, at(age)).norm()
        assert float(speed) == pytest.approx(0.15 / (0.5 + age))


def test_limits_of_late_readings_go_by_how_many_steps_they_are_old() -> None:
    wall = Clearance("x_wall", "z_wall", noise=0.01, motion_noise=0.0, dt=0.05, delay=4)
    limits = ClearanceLimits(time=0.5, margin=0.04, slowest=0.05)
    belief = {"x_wall": at(0.1, -1.0, 0.0), "P_wall": torch.zeros(3, 3, dtype=torch.float64)}
    allowed = wall.limits(limits)({"a": at(0.5, 0.0), **belief, "x_wall_lag": at(3.0), "dt": 0.05})
    torch.testing.assert_close(allowed, limits(at(0.5, 0.0), *belief.values(), at(0.15)))


@pytest.mark.parametrize("wrong", [{"noise": 0.0}, {"dt": -1.0}, {"motion_noise": -1.0}])
def test_numbers_that_cannot_be_are_errors(wrong: dict[str, float]) -> None:
    (name,) = wrong
    with pytest.raises(OptionError, match=name):
        Clearance("x_obs", "z_obs", **{"noise": 0.01, "motion_noise": 0.0, "dt": 0.05} | wrong)


def felt(clearance: Clearance, motions: list[Tensor]) -> tuple[dict[str, Tensor], float]:
    """What is believed of a wall to the right after some motions, and how far it is then, m."""
    estimator = clearance.estimator().double()
    left = 1.0
    values: dict[str, Any] = {"dt": at(0.05).squeeze(), "z_wall": at(left), "z_side": at(0.0)}
    values |= estimator.initial(values)
    for motion in motions:
        left -= float(motion[0])
        values |= estimator.update(values | {"z_wall": at(left), "moved": motion})
    return values, left
