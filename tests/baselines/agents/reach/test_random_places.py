"""An arm that is held up goes elsewhere, and comes back."""

import numpy as np
import pytest

from aicon_baselines.agents.reach.random_places import RandomPlaces

LOW, HIGH, DT = np.array([-1.0, -np.inf]), np.array([3.0, np.inf]), 0.02
HERE = np.array([-0.5, 0.0])


def held_up() -> RandomPlaces:
    """One whose cost has stayed the same until it goes elsewhere."""
    places, steps = RandomPlaces(LOW, HIGH, DT), 0
    while places.way(HERE, cost=0.3) is None:
        places.moved(0.0)
        steps += 1
    assert steps == pytest.approx(0.8 / DT, abs=2)
    return places


def test_it_goes_to_the_middle_half_of_all_ranges() -> None:
    found = []
    places = held_up()
    for _ in range(20):
        assert places.place is not None
        found.append(places.place)
        places.place, places.clock = None, 1.0
        places.way(HERE, cost=0.3)
    lowest, highest = np.min(found, axis=0), np.max(found, axis=0)
    assert (lowest > [0.0, -np.pi / 2]).all()
    assert (highest < [2.0, np.pi / 2]).all()
    assert (highest - lowest > [1.0, 1.0]).all()


@pytest.mark.parametrize("share", [0.0, 1.0])
def test_its_way_ends_where_it_is_slow_or_late(share: float) -> None:
    places, seconds = held_up(), 0.0
    while places.way(HERE, cost=0.3) is not None:
        places.moved(share)
        seconds += DT
    assert seconds == pytest.approx(2.5 if share else 0.1, abs=2 * DT)


def test_its_way_ends_near_its_place_and_its_target_is_followed_again() -> None:
    places = held_up()
    assert places.place is not None
    assert places.way(places.place + 0.3, cost=2.0) is None
    places.moved(1.0)
    assert places.way(HERE, cost=1.0) is None
    assert places.lowest == 1.0


def test_progress_and_arrival_hold_nothing_up() -> None:
    places = RandomPlaces(LOW, HIGH, DT)
    for step in range(200):
        assert places.way(HERE, cost=max(0.005, 2.0 * 0.95**step)) is None
        places.moved(1.0)
