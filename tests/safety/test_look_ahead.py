"""Before a place of the sequence is gone to, it is looked at: one that is closed is passed over."""

from typing import Any, cast

import pytest
import torch
from _inputs.places import DT, LIMITS, RANGE, Distance, doubled
from torch import Tensor

from aicon_torch.dampers import PlaceEscape
from aicon_torch.safety.look_ahead import END, HALFWAY, LookAhead
from aicon_torch.safety.place_search import KEPT
from aicon_torch.safety.places import Places, initial_places, spread

NOWHERE = torch.tensor([2.5, 0.0], dtype=torch.float64)
"""A target beyond the range."""


def place(number: int) -> Tensor:
    """A place of the sequence, as the way from the middle of both ranges."""
    return spread(torch.tensor(number), LIMITS)


def held_up(
    cost: Distance, looks_ahead: bool = True, seeks: bool = True, detours: int = 1
) -> dict[str, Tensor]:
    """What is remembered after some detours of one that is held up, and cannot move at all."""
    options = PlaceEscape(whole=(1, 1), seeks=seeks, looks_ahead=looks_ahead)
    places, memory = Places(options, LIMITS, DT), doubled(initial_places(2, options))
    nominal, still = torch.ones(2).double(), torch.zeros(2).double()
    while int(memory["escapes"]) < detours:
        memory = places.judge(cast(Any, cost), nominal, still, still, RANGE, memory)
    return memory


@pytest.mark.parametrize("seeks", [True, False])
@pytest.mark.parametrize("share", [1.0, 0.5])
def test_it_passes_over_a_place_that_is_closed_there_or_halfway(share: float, seeks: bool) -> None:
    closed = Distance(NOWHERE, closed=share * RANGE[0] * place(0), radius=0.05)
    looked, blind = held_up(closed, seeks=seeks), held_up(closed, looks_ahead=False, seeks=seeks)
    torch.testing.assert_close(looked["direction"], RANGE[0] * place(1))
    torch.testing.assert_close(blind["direction"], RANGE[0] * place(0))


def test_it_goes_to_the_first_place_where_that_is_open() -> None:
    memory = held_up(Distance(NOWHERE))
    torch.testing.assert_close(memory["direction"], RANGE[0] * place(0))
    assert int(memory["ahead"]) == 1


def test_after_the_first_each_place_of_the_sequence_has_one_known_one_before_it() -> None:
    """Which known one is tried does not matter: there is but one, and it is always blocked."""
    cost = Distance(torch.tensor([1.2, -0.7]).double())
    blind = [int(held_up(cost, detours=count)["blind"]) for count in range(1, KEPT + 6)]
    assert blind == [*[0] * KEPT, 1, 1, 2, 2, 3]


def look(turn: int, is_clear: bool) -> tuple[int, int]:
    """The number of the next place, which was 7, and what has its turn after a look."""
    ahead = LookAhead(torch.tensor(7), place(7), torch.tensor(turn))
    after = ahead.after(torch.tensor(is_clear))
    return int(after.number), int(after.turn)


def test_looks_take_turns() -> None:
    assert look(END, is_clear=True) == (7, HALFWAY)
    assert look(HALFWAY, is_clear=True) == (7, END)


@pytest.mark.parametrize("turn", [END, HALFWAY])
def test_a_place_that_is_closed_is_passed_over_and_the_next_one_is_looked_at(turn: int) -> None:
    assert look(turn, is_clear=False) == (8, END)


def test_what_is_tried_first_counts_in_the_sequence() -> None:
    options = PlaceEscape(looks_ahead=True)
    places, memory = Places(options, LIMITS, DT), initial_places(2, options)
    begun = places.first_to(torch.tensor(4), memory)
    assert int(places.next_number(begun)) == 5
