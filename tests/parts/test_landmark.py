"""A landmark that is seen: its residual, prior, motion and distance, and its estimator."""

import math
from typing import Any

import pytest
import torch
from _inputs import normal
from torch import Tensor

from aicon_torch import OptionError
from aicon_torch.parts import (
    BearingPrior,
    Landmark,
    approach,
    bearing_jacobian,
    bearing_residual,
    expected_distance,
)


def at(*coordinates: float) -> Tensor:
    return torch.tensor(coordinates, dtype=torch.float64)


def test_the_landmark_comes_nearer_by_what_the_robot_moves() -> None:
    moved = approach()({"p_tar": at(3.0, 1.0), "x_rob": at(0.5, -0.25)})
    assert moved.tolist() == [2.5, 1.25]


@pytest.mark.parametrize("turn", [0.0, 2 * math.pi, -2 * math.pi])
def test_the_residual_is_zero_where_the_bearing_is_right(turn: float) -> None:
    reading = at(math.atan2(1.0, -2.0) + turn)
    assert float(bearing_residual(at(-2.0, 1.0), reading)) == pytest.approx(0.0, abs=1e-12)


def test_the_jacobian_is_the_derivative() -> None:
    position = normal(6, 2).requires_grad_()
    residual = bearing_residual(position, torch.zeros(6, 1, dtype=torch.float64))
    (expected,) = torch.autograd.grad(residual.sum(), position)
    torch.testing.assert_close(bearing_jacobian(position).squeeze(-2), expected)


def test_nearer_than_a_centimetre_the_jacobian_grows_no_more() -> None:
    lengths = [float(bearing_jacobian(at(x, 0.0)).norm()) for x in (0.01, 0.005, 0.0)]
    assert lengths == pytest.approx([100.0, 50.0, 0.0])


def test_the_prior_is_uncertain_along_the_line_of_sight() -> None:
    mean, covariance = BearingPrior(5.0, across=0.15, along=3.0)(at(math.pi / 6))
    sight, across = at(math.cos(math.pi / 6), 0.5), at(-0.5, math.cos(math.pi / 6))

    torch.testing.assert_close(mean, 5.0 * sight)
    torch.testing.assert_close(covariance @ sight, 9.0 * sight)
    torch.testing.assert_close(covariance @ across, 0.0225 * across)


def test_the_expected_distance_is_the_paper_s() -> None:
    """‖μ‖ + tr Σ."""
    position, covariance = normal(3, 2), torch.diag_embed(normal(3, 2) ** 2)
    trace = covariance.diagonal(dim1=-2, dim2=-1).sum(-1)
    expected = position.norm(dim=-1) + trace
    torch.testing.assert_close(expected_distance(position, covariance), expected)


def test_a_landmark_is_found_under_any_name_by_its_bearing() -> None:
    """From two places far apart, the crossing of two lines of sight."""
    tree = Landmark("x_tree", "z_tree", noise=0.01, motion_noise=1e-4, motion="moved")
    found = estimated(tree, place=at(3.0, 2.0), motion=at(0.05, 0.0), steps=60)

    mean, covariance = found["x_tree"], found["P_tree"]
    torch.testing.assert_close(mean, at(0.0, 2.0), atol=0.05, rtol=0.0)
    expected = tree.expected_distance()(found)
    torch.testing.assert_close(expected, expected_distance(mean, covariance))


def test_a_landmark_that_is_seen_where_it_is_begins_there() -> None:
    tree = Landmark("x_tree", "z_tree", noise=0.01, motion_noise=0.0, sees="position")
    found = estimated(tree, place=at(3.0, 2.0), motion=at(0.05, 0.0), steps=4)
    torch.testing.assert_close(found["x_tree"], at(2.8, 2.0))
    assert float(found["P_tree"].diagonal().max()) == pytest.approx(0.01**2 / 5)


@pytest.mark.parametrize(
    "wrong", [{"noise": 0.0}, {"motion_noise": -1.0}, {"sees": "colour"}, {"delay": 1.5}]
)
def test_what_a_landmark_cannot_be_is_an_error(wrong: dict[str, Any]) -> None:
    (name,) = wrong
    with pytest.raises(OptionError, match=name):
        Landmark("p_tar", "z_tar", **{"noise": 0.01, "motion_noise": 0.0} | wrong)


def estimated(landmark: Landmark, place: Tensor, motion: Tensor, steps: int) -> dict[str, Tensor]:
    """What the filter believes after some steps of even motion."""
    estimator = landmark.estimator().double()
    values: dict[str, Any] = {
        "dt": torch.tensor(0.05, dtype=torch.float64),
        landmark.motion: motion,
        **seen(landmark, place),
    }
    values |= estimator.initial(values)
    for _ in range(steps):
        place = place - motion
        values |= estimator.update(values | seen(landmark, place))
    return values


def seen(landmark: Landmark, place: Tensor) -> dict[str, Tensor]:
    """The reading of a landmark at a place."""
    bearing = torch.atan2(place[1:], place[:1])
    return {landmark.reading: place if landmark.sees == "position" else bearing}
