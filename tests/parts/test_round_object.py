"""A round thing that is pushed, and slides on."""

import pytest
import torch
from torch import Tensor

from aicon_torch import OptionError
from aicon_torch.parts import ContactOptions, RoundObject

PUCK = RoundObject(0.03, pusher_radius=0.01, friction=0.5, contact=ContactOptions(size=0.1))
STEP = torch.tensor(0.05, dtype=torch.float64)


def point(x: float, y: float) -> Tensor:
    return torch.tensor([x, y], dtype=torch.float64)


@pytest.mark.parametrize("speed", [0.0, 0.1, 0.8])
def test_it_slides_until_friction_has_taken_its_velocity(speed: float) -> None:
    place, velocity = point(0.0, 0.0), point(speed, 0.0)
    for _ in range(40):
        slid = PUCK.slid(place, velocity, STEP)
        at_rest = PUCK.rest(place, slid, point(0.0, 0.0), velocity, STEP)
        assert float(at_rest[0]) == pytest.approx(speed**2 / (2 * 0.5 * 9.81), abs=1e-9)
        place, velocity = slid, (velocity - 0.5 * 9.81 * STEP).clamp(min=0.0)


def test_it_goes_as_far_as_the_pusher_goes_beyond_the_gap() -> None:
    way = point(0.03, 0.0)
    push = PUCK.push(point(0.06, 0.0), way, way)  # a gap of 2 cm
    torch.testing.assert_close(push, point(0.01, 0.0))
    torch.testing.assert_close(PUCK.push(point(0.06, 0.0), -way, -way), point(0.0, 0.0))


def test_friction_takes_it_along_within_its_cone() -> None:
    for aside, along in ((0.002, 0.002), (0.02, 0.005)):
        way = point(0.01, aside)
        push = PUCK.push(point(0.04, 0.0), way, way)
        torch.testing.assert_close(push, point(0.01, along))


def test_the_gradient_of_a_push_goes_by_the_way_of_the_pusher() -> None:
    way, pusher = point(0.03, 0.0).requires_grad_(), point(0.03, 0.0).requires_grad_()
    PUCK.push(point(0.06, 0.0), pusher, way)[0].backward()
    assert way.grad is not None
    torch.testing.assert_close(way.grad, point(1.0, 0.0))
    assert pusher.grad is None


@pytest.mark.parametrize(("goal", "toward"), [(1.0, 1.0), (-1.0, -1.0)])
def test_a_contact_draws_where_it_helps_and_repels_where_it_harms(
    goal: float, toward: float
) -> None:
    pusher, rest = point(-0.06, 0.0).requires_grad_(), point(0.0, 0.0)
    moved = PUCK.moved(rest, PUCK.normal(pusher, rest), PUCK.likelihood(pusher, rest))
    torch.testing.assert_close(moved.detach(), rest)

    (-goal * moved[0]).backward()
    assert pusher.grad is not None
    assert float(-pusher.grad[0]) * toward > 0


def test_numbers_are_positive() -> None:
    with pytest.raises(OptionError, match="friction"):
        RoundObject(0.03, 0.01, 0.0, ContactOptions(size=0.1))
