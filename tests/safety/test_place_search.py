"""While an actuator moves, a place is sought at which its goals are reached, and kept."""

from typing import Any, cast

import pytest
import torch
from _inputs.places import DT, LIMITS, RANGE, Distance, doubled

from aicon_torch.dampers import PlaceEscape
from aicon_torch.safety.place_search import IMAGINED, KEPT, Found, PlaceSearch, initial_search
from aicon_torch.safety.places import Places, initial_places

NEAR = 0.005
TARGET = torch.tensor([1.2, -0.7], dtype=torch.float64)


def searched(cost: Distance, steps: int = 8, moved: float = 0.0) -> Found:
    """What is found after some steps, in each of which the actuator moves by so much."""
    search, memory = PlaceSearch(LIMITS, NEAR, DT), doubled(initial_search(2))
    found = search(cast(Any, cost), RANGE, memory)
    for _ in range(steps):
        shift = torch.full((2,), moved, dtype=torch.float64)
        elsewhere = torch.tensor([-1.9, 1.9], dtype=torch.float64)
        memory = search.remembered(found, memory["places"], elsewhere, shift)
        cost.target = cost.target - shift
        found = search(cast(Any, cost), RANGE, memory)
    return found


def test_a_place_is_known_where_the_goals_are_reached() -> None:
    found = searched(Distance(TARGET))
    assert found.known.is_place.tolist() == [True] + [False] * (KEPT - 1)  # once, not twice
    torch.testing.assert_close(found.known.ways[0], TARGET)


def test_a_place_is_the_way_from_where_the_actuator_is() -> None:
    found = searched(Distance(TARGET), moved=0.01)
    torch.testing.assert_close(found.known.ways[0], TARGET - 0.08)


def test_no_place_is_known_where_a_gap_is_closed_or_beyond_the_range() -> None:
    assert not searched(Distance(TARGET, closed=TARGET + 0.3)).known.is_place.any()
    assert not searched(Distance(torch.tensor([2.5, 0.0]).double())).known.is_place.any()


def test_a_hopeless_place_is_given_up() -> None:
    search, memory = PlaceSearch(LIMITS, NEAR, DT), doubled(initial_search(2))
    cost, elsewhere = Distance(torch.tensor([2.5, 0.0]).double()), -torch.ones(2).double()
    for _ in range(16):
        found = search(cast(Any, cost), RANGE, memory)
        memory = search.remembered(found, memory["places"], elsewhere, torch.zeros(2).double())
    assert int(memory["places"]) in range(IMAGINED, 3 * IMAGINED)


def test_where_it_is_held_up_it_goes_to_the_place_that_it_knows() -> None:
    places, memory = Places(PlaceEscape(), LIMITS, DT), doubled(initial_places(2, PlaceEscape()))
    nominal, still = torch.ones(2).double(), torch.zeros(2).double()
    for _ in range(20):
        cost = cast(Any, Distance(TARGET))
        memory = places.judge(cost, nominal, still, still, RANGE, memory)
    assert memory["escaping"]
    torch.testing.assert_close(memory["direction"], TARGET)
    assert int(memory["escapes"]) == 1


@pytest.mark.parametrize("knew_none", [True, False])
def test_on_its_way_to_a_place_of_the_sequence_it_turns_to_one_if_it_knew_none(
    knew_none: bool,
) -> None:
    places, memory = Places(PlaceEscape(), LIMITS, DT), doubled(initial_places(2, PlaceEscape()))
    memory = places.first_to(torch.tensor(0), memory)
    if knew_none:
        memory["escapes"] = torch.tensor(1)
    target, room, nominal = TARGET.clone(), RANGE, torch.ones(2).double()

    for _ in range(8):
        assert memory["escaping"]
        action = places.aim(nominal, memory)
        cost = cast(Any, Distance(target))
        memory = places.judge(cost, nominal, action, action, room, memory)

        # The target and the stops are told from where the robot is.
        target = target - DT * action
        room = (room[0] + DT * action, room[1] - DT * action)
        if memory["to_known"]:
            break

    assert memory["knows"].any()
    assert bool(memory["to_known"]) == knew_none
    if knew_none:
        torch.testing.assert_close(memory["direction"], target, rtol=0, atol=2 * DT * 1.5)


def test_a_way_to_a_known_place_that_gets_no_shorter_is_left_for_another_one() -> None:
    places, memory = Places(PlaceEscape(), LIMITS, DT), doubled(initial_places(2, PlaceEscape()))
    nominal, still = torch.ones(2).double(), torch.zeros(2).double()
    led_to_known: list[bool] = []
    for _ in range(100):
        cost = cast(Any, Distance(TARGET))
        memory = places.judge(cost, nominal, still, still, RANGE, memory)
        led_to_known.append(bool(memory["escaping"] & memory["to_known"]))

        if int(memory["blind"]):
            break

    # The only place that is known was tried a few times in vain: then the sequence comes.
    assert True in led_to_known
    assert int(memory["escapes"] - memory["blind"]) == KEPT
    assert float(memory["tries"].max()) == KEPT
    assert memory["escaping"] & ~memory["to_known"]


def test_a_place_that_is_no_longer_clear_is_forgotten() -> None:
    search, memory = PlaceSearch(LIMITS, NEAR, DT), doubled(initial_search(2))
    elsewhere, still = torch.tensor([-1.9, 1.9]).double(), torch.zeros(2).double()
    for _ in range(8):
        found = search(cast(Any, Distance(TARGET)), RANGE, memory)
        memory = search.remembered(found, memory["places"], elsewhere, still)
    assert memory["knows"].any()

    for _ in range(3):
        found = search(cast(Any, Distance(TARGET, closed=TARGET)), RANGE, memory)
        memory = search.remembered(found, memory["places"], elsewhere, still)
    assert not memory["knows"].any()
