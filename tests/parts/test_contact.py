"""The contact model's geometry, for one side along the x axis with the object above it."""

import math

import pytest
import torch
from _inputs import normal
from torch import Tensor

from aicon_torch.parts import (
    ContactLikelihood,
    closest_point,
    fixed_closest_point,
    inward_normal,
    is_interior,
    tangent,
)

SIDE = torch.tensor([0.1, 0.0, 0.3, 0.0], dtype=torch.float64)
LIKELIHOOD = ContactLikelihood(reach=0.03, reaction=0.01, aim=0.008, facing=True, radius=0.015)


def at(*coordinates: float) -> Tensor:
    return torch.tensor(coordinates, dtype=torch.float64)


def likelihoods(pusher: Tensor) -> list[float]:
    found: list[float] = LIKELIHOOD(pusher, closest_point(pusher, SIDE), SIDE).tolist()
    return found


def test_a_side_has_a_direction_and_the_object_on_its_left() -> None:
    torch.testing.assert_close(tangent(SIDE), at(1.0, 0.0))
    torch.testing.assert_close(inward_normal(SIDE), at(0.0, 1.0))


@pytest.mark.parametrize(
    ("pusher", "point"),
    [((0.2, -0.05), (0.2, 0.0)), ((0.0, -0.05), (0.1, 0.0)), ((0.4, 0.2), (0.3, 0.0))],
)
def test_the_closest_point_is_the_foot_or_an_end(
    pusher: tuple[float, float], point: tuple[float, float]
) -> None:
    torch.testing.assert_close(closest_point(at(*pusher), SIDE), at(*point))


def test_no_point_of_a_side_is_closer_than_the_closest() -> None:
    pushers, sides = normal(20, 2), normal(20, 4, seed=1)
    nearest = (closest_point(pushers, sides) - pushers).norm(dim=-1)

    for share in torch.linspace(0.0, 1.0, 21, dtype=torch.float64):
        point = sides[:, :2] + share * (sides[:, 2:] - sides[:, :2])
        assert ((point - pushers).norm(dim=-1) >= nearest - 1e-12).all()


def test_the_fixed_point_is_the_same_without_a_gradient() -> None:
    pusher = at(0.2, -0.05).requires_grad_()
    assert closest_point(pusher, SIDE).requires_grad
    assert not fixed_closest_point(pusher, SIDE).requires_grad
    torch.testing.assert_close(fixed_closest_point(pusher, SIDE), closest_point(pusher, SIDE))


def test_the_ends_of_a_side_are_not_its_interior() -> None:
    points = torch.stack([at(0.1, 0.0), at(0.2, 0.0), at(0.3, 0.0)])
    assert is_interior(points, SIDE).tolist() == [False, True, False]


def test_a_contact_is_certain_where_the_disc_touches() -> None:
    """Intended and incidental, 0.015 m before the side; each falls by its own length."""
    assert likelihoods(at(0.2, -0.015)) == pytest.approx([1.0, 1.0])
    expected = [math.exp(-0.02 / 0.03), math.exp(-0.02 / 0.01)]
    assert likelihoods(at(0.2, -0.035)) == pytest.approx(expected)


def test_at_a_corner_harm_counts_as_far_as_the_side_faces_the_pusher() -> None:
    distance = math.hypot(0.03, 0.04)
    happens = math.exp(-(distance - 0.015) / 0.01)
    assert likelihoods(at(0.07, -0.04))[1] == pytest.approx(0.8 * happens)
    assert likelihoods(at(0.07, 0.04))[1] == 0.0  # from behind it does not face it at all


def test_the_likelihood_grows_towards_the_side_and_not_along_it() -> None:
    pusher = at(0.2, -0.05).requires_grad_()
    for likelihood in LIKELIHOOD(pusher, closest_point(pusher, SIDE), SIDE):
        (slope,) = torch.autograd.grad(likelihood, pusher, retain_graph=True)
        assert float(slope[1]) > 0
        assert float(slope[0]) == pytest.approx(0.0, abs=1e-12)


def test_with_an_inset_a_sought_contact_is_aimed_at_inside_the_side() -> None:
    """Off the end of a side the intended contact pulls toward its inside as well."""
    inset = ContactLikelihood(
        reach=0.03, reaction=0.01, aim=0.008, facing=True, radius=0.015, inset=0.015
    )
    pusher = at(0.1, -0.015).requires_grad_()
    intended, _ = inset(pusher, closest_point(pusher, SIDE), SIDE)
    intended.backward()
    assert pusher.grad is not None and float(pusher.grad[0]) > 0
