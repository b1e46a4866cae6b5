"""Robots on wheels: how they move, and what they see of what rests."""

import math
from collections.abc import Callable

import pytest
import torch
from _inputs import normal
from _inputs.wheels import CAR, DRIVE, WHEELS, rolled, seen
from torch import Tensor

from aicon_torch.errors import OptionError
from aicon_torch.parts import Bicycle, DifferentialDrive, Wheels, pose_error

every_robot = pytest.mark.parametrize("wheels", WHEELS.values(), ids=WHEELS)


def derivative(function: Callable[[Tensor], Tensor], at: Tensor) -> Tensor:
    """By autograd."""
    found = torch.autograd.functional.jacobian(function, at)
    assert isinstance(found, Tensor)
    return found


def test_twists_are_those_of_the_wheels() -> None:
    turning = torch.tensor([[0.1, 0.1], [-0.15, 0.15], [0.0, 0.3]])
    torch.testing.assert_close(
        DRIVE.twist(turning), torch.tensor([[0.1, 0.0], [0.0, 1.0], [0.15, 1.0]])
    )
    steered = torch.tensor([[0.3, 0.0], [0.3, math.pi / 4], [0.0, 0.5]])
    torch.testing.assert_close(
        CAR.twist(steered), torch.tensor([[0.3, 0.0], [0.3, 1.0], [0.0, 0.0]])
    )


@every_robot
def test_the_point_ahead_moves_in_any_direction_alike(wheels: Wheels) -> None:
    """x_rob is its motion in the robot's axes: in the world's it is turned, and as long."""
    pose = torch.tensor([1.0, 2.0, 0.7], dtype=torch.float64)

    def point_ahead(x_rob: Tensor) -> Tensor:
        return wheels.point_ahead(wheels.moved(pose, x_rob))

    found = derivative(point_ahead, torch.zeros(2, dtype=torch.float64))
    cos, sin = math.cos(0.7), math.sin(0.7)
    torch.testing.assert_close(found, found.new_tensor([[cos, -sin], [sin, cos]]))


@every_robot
def test_it_moves_as_its_wheels_roll(wheels: Wheels) -> None:
    """But for the length of a chord instead of an arc, θ²/24 of it."""
    pose, action = normal(50, 3), 0.3 * normal(50, 2, seed=1)
    x_rob = wheels.motion(action, 0.05)
    expected = rolled(pose, wheels.twist(action))
    error = pose_error(wheels.moved(pose, x_rob), expected, 1.0)

    turn, way = wheels.twist(action)[..., 1:] * 0.05, x_rob[..., :1].abs()
    assert (error.abs() <= way * turn**2 / 20 + 1e-12).all()


@every_robot
def test_what_rests_is_seen_where_it_is_after_a_step(wheels: Wheels) -> None:
    pose, place, x_rob = normal(20, 3), normal(20, 2, seed=1), 0.1 * normal(20, 2, seed=2)
    moved = wheels.moved(pose, x_rob)
    found = wheels.seen_after(seen(pose, place), x_rob)
    torch.testing.assert_close(found, seen(moved, place))

    rotated = wheels.axes_after(x_rob[0])
    expected = derivative(lambda p: wheels.seen_after(p, x_rob[0]), place[0])
    torch.testing.assert_close(rotated, expected)


@every_robot
def test_an_error_of_the_motion_counts_for_more_far_away(wheels: Wheels) -> None:
    """The variances are no less than those that the error brings about."""
    place = torch.tensor([2.0, -1.0], dtype=torch.float64)
    lever = derivative(lambda x_rob: wheels.seen_after(place, x_rob), torch.zeros(2).double())
    least = 0.01**2 * (lever @ lever.mT).diagonal()
    found = wheels.variances(place, 0.01)
    assert (found >= least - 1e-12).all() and (found <= least + 0.01**2 + 1e-12).all()


@pytest.mark.parametrize("number", [0.0, -0.3, math.nan])
def test_sizes_are_positive(number: float) -> None:
    with pytest.raises(OptionError, match="track="):
        DifferentialDrive(number)
    with pytest.raises(OptionError, match="wheelbase="):
        Bicycle(number)
