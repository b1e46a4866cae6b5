"""The documents say how many numbers are set by hand; the options know it."""

import sys
from importlib import import_module

import pytest

from count_numbers import WORLDS, numbers_in, numbers_of


@pytest.mark.parametrize(
    ("task", "shared", "by_hand", "privileged"),
    [("nav2d", 10, 5, 0), ("pusht", 10, 5, 0), ("arm_push", 8, 34, 5), ("reach", 6, 25, 0)],
)
def test_the_documents_count_the_numbers_that_there_are(
    task: str, shared: int, by_hand: int, privileged: int
) -> None:
    counts = [sum(kind.values()) for kind in numbers_of(task)]
    assert counts == [shared, by_hand, privileged]


def test_a_number_that_serves_nothing_is_not_counted() -> None:
    escape = "resolution.exploration.escape.hold_gain"
    assert escape in numbers_of("nav2d").by_hand
    assert escape not in numbers_of("pusht").by_hand


@pytest.mark.parametrize("world", ["pointmaze", "ogbench_mazes", "fetch", "meta_world"])
def test_a_world_of_others_has_four_numbers_at_most(
    world: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "path", [str(WORLDS), *sys.path])
    assert sum(numbers_in(import_module(world).Options()).by_hand.values()) <= 4
