import pytest
import torch
from torch import Tensor

from aicon_torch.errors import OptionError
from aicon_torch.parts import Room, worth_of_room

ROOM = Room(size=0.04, rest=0.02, slack=0.01, clearance=0.05)


def leaf(*values: float) -> Tensor:
    return torch.tensor([values], dtype=torch.float64, requires_grad=True)


LOW, HIGH, ELSEWHERE = leaf(0.0, 0.0, 0.02), leaf(0.0, 0.0, 0.06), leaf(0.3, 0.0, 0.02)


@pytest.mark.parametrize(("gap", "expected"), [(0.01, 0.0), (0.06, 0.5), (0.1, 1.0)])
def test_a_place_is_taken_by_what_stands_there(gap: float, expected: float) -> None:
    room = ROOM(LOW, leaf(gap, 0.0, 0.02), ELSEWHERE)
    assert room.item() == pytest.approx(expected)


def test_what_takes_a_place_is_worth_moving_away_even_from_its_middle() -> None:
    other = leaf(0.01, 0.0, 0.02)
    (slope,) = torch.autograd.grad(
        worth_of_room(leaf(1.0)[:, 0], ROOM(LOW, other, ELSEWHERE)), other
    )
    assert slope[0, 0] < 0  # the cost falls as it goes on outward


def test_above_the_table_a_place_carries_once_what_belongs_below_is_there() -> None:
    rooms = [ROOM(HIGH, leaf(x, 0.0, 0.02), LOW).item() for x in (0.0, 0.3)]
    assert rooms == pytest.approx([1.0, 0.0])


def test_of_a_stack_the_highest_is_carried_by_the_one_right_below_it_alone() -> None:
    highest = leaf(0.0, 0.0, 0.10)
    lowest, middle, away = leaf(0.0, 0.0, 0.02), leaf(0.0, 0.0, 0.06), leaf(0.3, 0.0, 0.02)
    rooms = [ROOM(highest, lowest, LOW, other, HIGH) for other in (middle, away)]
    assert [room.item() for room in rooms] == pytest.approx([1.0, 0.0])

    (slope,) = torch.autograd.grad(rooms[1].sum(), lowest)
    assert not slope.any()  # it is where it belongs


@pytest.mark.parametrize("missing", [None, 0, 5])
def test_a_tower_of_many_is_carried_by_all_of_them(missing: int | None) -> None:
    things: list[Tensor] = []
    for number in range(9):  # the highest first
        its_place = leaf(0.0, 0.0, 0.02 + 0.04 * (8 - number))
        things += [ELSEWHERE if number == missing else its_place, its_place]
    room = ROOM(leaf(0.0, 0.0, 0.38), *things)
    assert room.item() == pytest.approx(1.0 if missing is None else 0.0)


def test_a_stack_is_worth_building_from_the_lowest_on() -> None:
    highest, beside = leaf(0.0, 0.0, 0.10), leaf(0.08, 0.0, 0.02)
    for lowest, low_counts in ((leaf(0.3, 0.0, 0.02), True), (leaf(0.0, 0.0, 0.02), False)):
        room = ROOM(highest, lowest, LOW, beside, HIGH)
        by_lowest, by_middle = torch.autograd.grad(room.sum(), (lowest, beside))
        assert room.item() == 0 and by_lowest.any() == low_counts != by_middle.any()


def test_what_carries_comes_from_above_as_well() -> None:
    other = leaf(0.05, 0.0, 0.02)
    (slope,) = torch.autograd.grad(ROOM(HIGH, other, LOW), other)
    assert slope[0, 0] < 0 < slope[0, 2]  # inward, and up


def test_a_cost_keeps_its_value_and_counts_by_its_room() -> None:
    cost, room = torch.tensor([3.0], requires_grad=True), torch.tensor([[0.25]], requires_grad=True)
    value = worth_of_room(cost, room)
    by_cost, by_room = torch.autograd.grad(value, (cost, room))
    assert (value.item(), by_cost.item(), by_room.item()) == (3.0, 0.25, -3.0)


def test_a_length_that_is_not_positive_is_refused() -> None:
    with pytest.raises(OptionError, match="size"):
        Room(size=0.0, rest=0.02, slack=0.01, clearance=0.05)
