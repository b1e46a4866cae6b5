"""The documents say how many numbers are set by hand; the options know it."""

import pytest

from count_numbers import numbers_of


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
