"""Where an actuator is held up it goes elsewhere, on the other side of the stops where it was."""

from collections.abc import Iterator
from typing import Any, cast

import pytest
import torch
from torch import Tensor

from aicon_torch.dampers import PlaceEscape
from aicon_torch.errors import OptionError
from aicon_torch.safety.places import Places, initial_places

LIMITS = torch.full((5,), 1.5, dtype=torch.float64)
DT = 0.02


class Cost:
    """A cost that is given, and can change by so much in a step."""

    def __init__(self, cost: float) -> None:
        self.at_rest = torch.tensor(cost, dtype=torch.float64)

    def steepness(self, limits: Tensor) -> Tensor:
        return torch.tensor(0.01, dtype=torch.float64)

    def slope(self, action: Tensor) -> tuple[Tensor, Tensor]:
        return self.at_rest.expand(action.shape[:-1]), torch.zeros_like(action)

    def of_safety(self, action: Tensor) -> Tensor:
        return torch.zeros_like(action[..., 0])


def remembered(
    costs: list[float], down: list[float], up: list[float], **options: Any
) -> dict[str, Tensor]:
    """What is remembered after some steps with these costs, at rest in the middle of a step."""
    return list(remembering(costs, down, up, **options))[-1]


def remembering(
    costs: list[float], down: list[float], up: list[float], **options: Any
) -> Iterator[dict[str, Tensor]]:
    """What is remembered after each of them."""
    places = Places(PlaceEscape(**options), LIMITS, DT)
    memory = {
        key: value.double() if value.is_floating_point() else value
        for key, value in initial_places(5, places.options).items()
    }
    nominal = torch.ones(5, dtype=torch.float64)
    room = (torch.tensor(down, dtype=torch.float64), torch.tensor(up, dtype=torch.float64))
    for cost in costs:
        still = torch.zeros(5, dtype=torch.float64)
        memory = places.judge(cast(Any, Cost(cost)), nominal, still, still, room, memory)
        yield memory


MIDDLE, ANY = [2.0] * 5, [torch.inf] * 5


def test_a_cost_that_does_not_fall_is_being_held_up() -> None:
    patient = round(0.45 / (1.5 * DT))
    assert not remembered([0.5] * (patient - 2), MIDDLE, MIDDLE)["escaping"]
    assert remembered([0.5] * (patient + 2), MIDDLE, MIDDLE)["escaping"]

    falling = [0.5 * 0.99**step for step in range(60)]
    assert not remembered(falling, MIDDLE, MIDDLE)["escaping"]
    assert not remembered([0.004] * 60, MIDDLE, MIDDLE)["escaping"]  # near enough


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_the_next_places_are_on_the_other_side_of_a_stop(side: float) -> None:
    down, up = list(MIDDLE), list(MIDDLE)
    (down if side < 0 else up)[1] = 0.05
    (up if side < 0 else down)[1] = 4.0

    for memory in list(remembering([0.5] * 200, down, up))[19::40]:
        assert memory["stops"][1] == side
        assert memory["place"][1] * side < 0

    forgetful = remembered([0.5] * 200, down, up, remembers=False)
    assert (forgetful["stops"] == 0).all()


def test_a_way_leads_to_a_place_within_the_ranges() -> None:
    memory = remembered([0.5] * 20, [1.0] * 5, [3.0] * 5)
    here = -torch.ones(5, dtype=torch.float64)  # of the middle, in ranges of ±2
    there = here + memory["direction"]
    torch.testing.assert_close(there, 2.0 * memory["place"])
    assert memory["place"][1].abs() <= 0.5


def test_a_component_without_a_range_moves_by_a_share_of_half_a_turn_and_is_there() -> None:
    places, memory = Places(PlaceEscape(), LIMITS, DT), remembered([0.5] * 20, ANY, ANY)
    nominal, room = torch.ones(5, dtype=torch.float64), (torch.tensor(ANY), torch.tensor(ANY))
    place, moved = memory["place"], torch.zeros(5, dtype=torch.float64)
    torch.testing.assert_close(memory["direction"], torch.pi * place)

    for _ in range(60):
        action = places.aim(nominal, memory)
        moved = moved + DT * action
        memory = places.judge(cast(Any, Cost(0.5)), nominal, action, action, room, memory)
        if not memory["escaping"]:
            break
    assert not memory["escaping"]
    assert (moved - torch.pi * place).abs().max() < 0.4


def test_other_goals_forget_the_stops() -> None:
    known = remembered([0.5] * 20, [0.05] * 5, [4.0] * 5)
    assert (known["stops"] == -1).all()
    forgotten = remembered([0.5] * 20 + [5.0], [0.05] * 5, [4.0] * 5)
    assert (forgotten["stops"] == 0).all()
    assert not forgotten["escaping"]


def test_what_is_remembered_is_finite() -> None:
    for memory in list(remembering([0.5] * 200, MIDDLE, MIDDLE))[::20]:
        for value in memory.values():
            assert torch.isfinite(value.double()).all()


def test_patience_is_positive() -> None:
    with pytest.raises(OptionError, match="patience=0.0: expected a positive number"):
        PlaceEscape(patience=0.0)
