import math

import pytest
import torch
from torch import Tensor

from aicon_torch.errors import OptionError
from aicon_torch.parts import Carrying, Grasp, Gripper, Held, approached, carried, way_from_above

GRIPPER = Gripper(narrowest=0.02, widest=0.12, speed=0.3)
GRASP = Grasp(GRIPPER, size=0.04, height=0.01, reach=0.05)
CARRYING = Carrying(step=0.05, rest=0.02, rise=0.04)


def leaf(*values: float) -> Tensor:
    return torch.tensor([values], dtype=torch.float64, requires_grad=True)


def slopes(rel: Tensor, opening: Tensor, sign: float = -1.0) -> tuple[Tensor, Tensor]:
    """How a cost changes that falls (-1) or grows (1) with the likelihood of a grasp."""
    likelihood = GRASP.likelihood(rel, opening)
    by_rel, by_opening = torch.autograd.grad(sign * likelihood.sum(), (rel, opening))
    return by_rel, by_opening


def test_fingers_open_on_the_way_and_close_about_the_object() -> None:
    _, far = slopes(leaf(0.1, 0.05, 0.2), leaf(0.06))
    _, there = slopes(leaf(0.0, 0.0, 0.01), leaf(0.06))
    assert far < 0 < there  # the cost falls as they open, and as they close


def test_beside_the_object_the_tip_is_drawn_above_it_first() -> None:
    beside, _ = slopes(leaf(0.1, 0.0, 0.01), leaf(0.12))
    above, _ = slopes(leaf(0.0, 0.0, 0.1), leaf(0.12))
    assert beside[0, 2] < 0 < above[0, 2]


def test_fingers_that_are_too_narrow_rise_from_the_object_and_open() -> None:
    for opening in (0.02, 0.045):
        motion, fingers = slopes(leaf(0.0, 0.0, 0.04), leaf(opening))
        assert motion[0, 2] < 0 and fingers < 0

    wide, _ = slopes(leaf(0.0, 0.0, 0.04), leaf(0.06))
    assert wide[0, 2] > 0


def test_fingers_that_open_no_farther_than_the_object_come_down_all_the_same() -> None:
    tight = Grasp(Gripper(narrowest=0.02, widest=0.05, speed=0.3), 0.04, height=0.01, reach=0.05)
    likelihood = tight.likelihood(tip := leaf(0.0, 0.0, 0.04), leaf(0.05))
    assert torch.autograd.grad(-likelihood.sum(), tip)[0][0, 2] > 0


def test_one_comes_from_above_and_sinks_as_one_comes() -> None:
    for beside, height in ((0.0, 0.0), (0.015, 0.02), (0.1, 0.05)):
        way = way_from_above(leaf(beside, 0.0, 0.0), 0.01, 0.05)
        assert way.item() == pytest.approx(math.hypot(beside, height), abs=1e-6)


def test_fingers_turn_to_the_side_of_the_object_and_it_turns_with_them() -> None:
    motion, _ = slopes(leaf(0.0, 0.0, 0.01, 0.008), leaf(0.06))
    assert motion[0, 3] > 0 and not motion[0, :3].any()

    held = CARRYING(leaf(0, 0, 0.06, 0), tip := leaf(0, 0, 0.06, 0), *map(leaf, (1.0, 1.0, 1.0)))
    turned = torch.autograd.grad(held[0, 3], tip)[0]
    torch.testing.assert_close(turned, leaf(0, 0, 0, 1).detach())


def test_letting_go_opens_the_fingers_in_the_middle_and_rises_once_they_are_open() -> None:
    motion, opening = slopes(leaf(0.002, 0.0, 0.01), leaf(0.02), sign=1.0)
    assert opening < 0 < motion[0, 0] and not motion[0, 1:].any()

    motion, _ = slopes(leaf(0.002, 0.0, 0.01), leaf(GRIPPER.widest), sign=1.0)
    assert motion[0, 2] < 0 and not motion[0, :2].any()


def test_open_fingers_rise_until_they_are_about_the_object_no_longer() -> None:
    widest = leaf(GRIPPER.widest)
    among, clear = (slopes(leaf(0.0, 0.0, 0.01 + rise), widest, 1.0)[0] for rise in (0.02, 0.08))
    assert among[0, 2] < 0 and clear[0, 2] == pytest.approx(0.0, abs=1e-9)


def test_fingers_about_one_object_come_to_hold_no_other() -> None:
    beside, opening = leaf(0.3, 0.0, 0.03), leaf(GRIPPER.widest)
    alone = GRASP.likelihood(beside, opening)
    about, clear = (
        GRASP.likelihood(beside, opening, leaf(0.0, 0.0, 0.01 + rise)) for rise in (0.015, 0.08)
    )
    assert about < 0.01 * alone and clear.item() == pytest.approx(alone.item(), abs=1e-6)


def test_the_likelihood_is_largest_where_the_object_is_held() -> None:
    held = GRASP.likelihood(leaf(0.0, 0.0, 0.01), leaf(0.02))
    assert held.item() == pytest.approx(1.0, abs=1e-3)
    for rel, opening in (((0.0, 0.0, 0.03), 0.02), ((0.0, 0.0, 0.01), 0.05)):
        assert GRASP.likelihood(leaf(*rel), leaf(opening)) < held


def test_it_is_held_between_closed_fingers_alone() -> None:
    estimator = Held(GRASP)
    for rel, opening, expected in (
        ((0.0, 0.0, 0.01), 0.02, 1.0),
        ((0.0, 0.0, 0.01), 0.06, 0.0),
        ((0.05, 0.0, 0.01), 0.02, 0.0),
    ):
        values = {"x_rel": leaf(*rel), "x_opening": leaf(opening)}
        assert estimator.update(values)["p_held"].item() == pytest.approx(expected, abs=1e-3)


def test_a_bar_is_held_by_open_fingers_too() -> None:
    values = {"x_rel_bar": leaf(0.0, 0.0, 0.01), "x_opening": leaf(GRIPPER.widest)}
    assert Held(GRASP, "_bar", by_open_fingers=True).update(values)["p_held_bar"].item() > 0.99


def test_what_is_held_moves_with_the_tip_and_keeps_its_place_in_the_hand() -> None:
    a, dt = leaf(0.1, 0.0, -0.2), torch.tensor(0.1, dtype=torch.float64)
    for held in (0.0, 0.3, 1.0):
        moved = carried(leaf(0.0, 0.0, 0.0), leaf(held), a, dt)
        apart = approached(leaf(0.0, 0.0, 0.0), leaf(held), a, dt)
        torch.testing.assert_close(moved, held * a * dt)
        torch.testing.assert_close(moved + apart, a * dt)


def goal_slopes(height: float, held: float) -> tuple[Tensor, ...]:
    """Of ½‖x_obj − x*‖² by p_grasp, x_tip and p_free, 6 cm beside the place."""
    position, tip, grasp = leaf(0.06, 0.0, height), leaf(0.06, 0.0, height), leaf(0.5)
    free = CARRYING.free(position).detach().requires_grad_()
    moved = CARRYING(position, tip, grasp, leaf(held), free)
    torch.testing.assert_close(moved, position)  # the object is where it is
    cost = (moved - moved.new_tensor((0.0, 0.0, 0.02))).square().sum() / 2
    return torch.autograd.grad(cost, (grasp, tip, free))


def test_far_from_its_place_an_object_is_to_be_grasped_then_lifted_then_carried() -> None:
    grasp, tip, free = goal_slopes(height=0.02, held=0.0)
    assert grasp < 0 and not tip.any() and not free.any()

    _, tip, free = goal_slopes(height=0.02, held=1.0)
    assert free < 0 and not tip.any()

    _, tip, _ = goal_slopes(height=0.06, held=1.0)
    assert tip[0, 0] > 0 and tip[0, 2] > 0  # the cost falls against the error


def test_a_batch_is_its_rows() -> None:
    rel, opening = torch.randn(5, 3) * 0.05, torch.rand(5, 1) * 0.1
    rows = [GRASP.likelihood(x, o) for x, o in zip(rel, opening, strict=True)]
    torch.testing.assert_close(GRASP.likelihood(rel, opening), torch.stack(rows))


def test_an_opening_follows_its_rate_between_its_ends_and_can_be_steered_there() -> None:
    dt = torch.tensor(0.1)
    for start, rate, expected in ((0.05, 0.1, 0.06), (0.115, 0.3, 0.12), (0.03, -0.3, 0.02)):
        told = torch.tensor([rate], requires_grad=True)
        values = {"x_opening": torch.tensor([start]), "jaw": told, "dt": dt}
        opening = GRIPPER(values, "x_opening")
        assert opening.item() == pytest.approx(expected)
        assert torch.autograd.grad(opening.sum(), told)[0].item() == pytest.approx(0.1)


def test_what_cannot_be_is_refused() -> None:
    with pytest.raises(OptionError, match="narrowest <= first <= widest"):
        Gripper(narrowest=0.1, widest=0.05, speed=0.3)
    with pytest.raises(OptionError, match="speed=0"):
        Gripper(narrowest=0.0, widest=0.05, speed=0)
    with pytest.raises(OptionError, match="reach"):
        Grasp(GRIPPER, size=0.04, height=0.0, reach=0.0)
    with pytest.raises(OptionError, match="clearance=-0.1"):
        Grasp(GRIPPER, size=0.04, height=0.0, reach=0.1, clearance=-0.1)
