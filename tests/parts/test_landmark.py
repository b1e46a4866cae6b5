"""A landmark of which the bearing is seen: its residual, prior, motion and distance."""

import math

import pytest
import torch
from _inputs import normal
from torch import Tensor

from aicon_torch.parts import (
    BearingPrior,
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
