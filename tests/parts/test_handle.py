import pytest
import torch
from torch import Tensor

from aicon_torch.errors import OptionError
from aicon_torch.parts import Button, Grasp, Gripper, Handle

HANDLE = Handle(step=0.05, axis=(0.0, 1.0, 0.0), travel=0.16)
GRIPPER = Gripper(narrowest=0.02, widest=0.08, speed=0.5)
BUTTON = Button(Grasp(GRIPPER, size=0.04, height=0.0, reach=0.05), clearance=0.06)


def leaf(*values: float) -> Tensor:
    return torch.tensor([values], dtype=torch.float64, requires_grad=True)


def told(way: float, asked: float, unlocked: float = 1.0) -> tuple[Tensor, ...]:
    """What tip, grasp and lock are told of a cost that falls as the handle goes a way asked for."""
    tip, grasp, lock = leaf(0.3, 0.0, 0.1), leaf(0.5), leaf(unlocked)
    moved = HANDLE(leaf(0.3, 0.0, 0.1), tip, grasp, leaf(1.0), lock, leaf(way))
    return torch.autograd.grad(-asked * moved[0, 1], (tip, grasp, lock), materialize_grads=True)


def test_it_goes_along_its_axis_with_the_hand_and_the_hand_goes_anywhere() -> None:
    held, velocity, dt = leaf(1.0), leaf(0.1, 0.2, -0.3), torch.tensor(0.1)
    torch.testing.assert_close(
        HANDLE.carried(leaf(0.0, 0.0, 0.0), held, velocity, dt), leaf(0.0, 0.02, 0.0)
    )
    torch.testing.assert_close(
        HANDLE.approached(leaf(0.0, 0.0, 0.0), held, velocity, dt), leaf(0.01, 0.0, -0.03)
    )


def test_what_is_wanted_of_it_moves_the_tip_along_its_axis_and_is_worth_a_grasp() -> None:
    tip, grasp, _ = told(way=0.08, asked=1.0)
    assert tip[0, 1] < 0 and not tip[0, [0, 2]].any()
    assert grasp < 0


def test_a_lock_is_told_what_a_motion_is_worth_and_hand_and_grasp_are_told_nothing() -> None:
    tip, grasp, lock = told(way=0.08, asked=1.0, unlocked=0.0)
    assert lock < 0 and not tip.any() and not grasp.any()


@pytest.mark.parametrize(("way", "onward"), [(0.0, -1.0), (0.16, 1.0)])
def test_at_an_end_nothing_is_asked_for_that_leads_on(way: float, onward: float) -> None:
    assert not any(gradient.any() for gradient in told(way, onward))
    assert all(gradient.any() for gradient in told(way, -onward))


def test_a_press_changes_a_button() -> None:
    for state, sign in ((0.0, 1.0), (1.0, -1.0)):
        tip, opening = leaf(0.0, 0.0, 0.05), leaf(0.05)
        on = BUTTON(leaf(state), tip, opening, leaf(0.0, 0.0, 0.0))
        assert on.item() == state

        # To be changed the button is pressed, by closed fingers.
        down, closed = torch.autograd.grad(-sign * on.sum(), (tip, opening))
        assert down[0, 2] > 0 and closed > 0


def test_to_stay_as_it_is_a_button_is_left_upward() -> None:
    tip = leaf(0.002, 0.0, -0.005)
    on = BUTTON(leaf(1.0), tip, leaf(0.02), leaf(0.0, 0.0, 0.0))
    (away,) = torch.autograd.grad(-on.sum(), tip)
    assert away[0, 2] < 0 and not away[0, :2].any()


def test_beside_a_button_the_tip_is_drawn_above_it_first() -> None:
    tip = leaf(0.1, 0.0, 0.0)
    on = BUTTON(leaf(0.0), tip, leaf(0.02), leaf(0.0, 0.0, 0.0))
    (motion,) = torch.autograd.grad(-on.sum(), tip)
    assert motion[0, 2] < 0 < motion[0, 0]


def test_a_hand_that_holds_something_is_drawn_to_no_button() -> None:
    tip, in_hand, elsewhere = leaf(0.1, 0.0, 0.0), leaf(0.0, 0.0, 0.0), leaf(0.1, 0.0, 0.0)
    for x_rel, is_drawn in ((in_hand, False), (elsewhere, True)):
        on = BUTTON(leaf(0.0), tip, leaf(0.02), leaf(0.0, 0.0, 0.0), x_rel)
        (motion,) = torch.autograd.grad(on.sum(), tip)
        assert on.item() == 0.0 and bool(motion.any()) == is_drawn


def test_lengths_are_positive_and_an_axis_leads_up() -> None:
    with pytest.raises(OptionError, match="travel"):
        Handle(step=0.05, axis=(0.0, 1.0, 0.0), travel=0.0)
    with pytest.raises(OptionError, match="axis"):
        Handle(step=0.05, axis=(0.0, -1.0, 0.0), travel=0.16)
    with pytest.raises(OptionError, match="clearance"):
        Button(BUTTON.grasp, clearance=0.0)
