"""Discs that move: the cost of standing where one of them will come near."""

import math

import pytest
import torch
from torch import Tensor

from aicon_torch.errors import GraphError, OptionError
from aicon_torch.parts import MovingDiscs

DT, RADIUS, LENGTH, HORIZON = 0.1, 0.6, 0.1, 2.0
HERE = torch.zeros(2, dtype=torch.float64)


def discs(spread: float = 0.0) -> MovingDiscs:
    return MovingDiscs(RADIUS, DT, LENGTH, spread, HORIZON)


def readings(*ways: tuple[float, float, float, float]) -> Tensor:
    """What is read of discs at (x, y) with the velocities (u, v), and was a step before."""
    state = torch.tensor(ways, dtype=torch.float64)
    place, velocity = state[:, :2], state[:, 2:]
    return torch.cat((place - DT * velocity, place)).flatten()


def test_each_disc_counts_where_it_comes_nearest_within_the_horizon() -> None:
    passes = discs()(HERE, readings((1.5, 1.0, -1.0, 0.0)))  # beside the robot, in 1.5 s
    too_far = discs()(HERE, readings((5.0, 0.0, -1.0, 0.0)))  # 3 m away at the end
    leaves = discs()(HERE, readings((1.0, 0.0, 1.0, 0.0)))

    gaps = torch.tensor([1.0, 3.0, 1.0], dtype=torch.float64) - RADIUS
    torch.testing.assert_close(torch.stack((passes, too_far, leaves)), torch.exp(-gaps / LENGTH))

    both = readings((1.5, 1.0, -1.0, 0.0), (1.0, 0.0, 1.0, 0.0))
    torch.testing.assert_close(discs()(HERE, both), passes + leaves)


def test_the_farther_ahead_the_less_a_gap_is_sure() -> None:
    soon, later = readings((0.5, 1.0, -1.0, 0.0)), readings((1.5, 1.0, -1.0, 0.0))
    assert discs(spread=0.2)(HERE, later) > discs(spread=0.2)(HERE, soon)

    # Where it hits, the slope is the gentler the farther ahead.
    slopes = []
    for seconds in (0.5, 1.5):
        position = HERE.clone().requires_grad_()
        cost = discs(spread=0.2)(position, readings((seconds, RADIUS, -1.0, 0.0)))
        slopes.append(float(torch.autograd.grad(cost, position)[0][1]))
    assert slopes == pytest.approx([1 / (LENGTH + 0.2 * 0.5), 1 / (LENGTH + 0.2 * 1.5)])


def test_the_gradient_leads_out_of_the_way() -> None:
    position = torch.tensor([0.0, -0.1], dtype=torch.float64, requires_grad=True)
    cost = discs()(position, readings((1.5, 0.0, -1.0, 0.0)))
    (gradient,) = torch.autograd.grad(cost, position)
    along, across = gradient.tolist()
    assert across > 0 and math.isclose(along, 0.0, abs_tol=1e-9)


def test_rows_stand_alone_and_a_disc_that_stands_is_one_where_it_is() -> None:
    standing = readings((1.0, 0.0, 0.0, 0.0))
    rows = torch.stack((standing, readings((2.0, 1.0, -1.0, 0.0))))
    costs = discs(0.1)(HERE.expand(2, 2), rows)
    single = torch.stack([discs(0.1)(HERE, row) for row in rows])
    assert torch.equal(costs, single)
    assert float(costs[0]) == pytest.approx(math.exp(-(1.0 - RADIUS) / LENGTH))


@pytest.mark.parametrize("number", [{"length": 0.0}, {"dt": -0.1}, {"spread": -1.0}])
def test_a_number_that_it_may_not_be_is_an_error(number: dict[str, float]) -> None:
    numbers = {"radius": 0.6, "dt": 0.1, "length": 0.1, "spread": 0.1, "horizon": 2.0}
    with pytest.raises(OptionError, match=next(iter(number))):
        MovingDiscs(**numbers | number)


@pytest.mark.parametrize(("place", "read"), [(2, 5), (2, 6), (3, 8), (1, 4)])
def test_what_is_no_place_in_the_plane_is_an_error(place: int, read: int) -> None:
    with pytest.raises(GraphError, match=f"of {place} numbers, and {read} of the discs: expected"):
        discs()(torch.zeros(3, place), torch.zeros(3, read))
