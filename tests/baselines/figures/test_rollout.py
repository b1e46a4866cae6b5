"""The panels of a rollout: their order, and their marks over time."""

import pytest
from matplotlib.figure import Figure

from aicon_baselines.figures.rollout import Panel, increasing, mark_panels


@pytest.mark.parametrize(
    ("steps", "last", "expected"),
    [
        ([3, 5, 9], 9, [3, 5, 9]),
        ([0, 0, 0], 9, [1, 2, 3]),
        ([9, 9, 9], 9, [7, 8, 9]),
        ([5, 2, 30], 6, [4, 5, 6]),
        ([1, 2, 3], 3, [1, 2, 3]),
    ],
)
def test_steps_increase_within_the_episode(
    steps: list[int], last: int, expected: list[int]
) -> None:
    assert increasing(steps, last) == expected


def test_marks_stand_at_the_times_of_the_panels() -> None:
    figure = Figure()
    upper, lower = figure.add_subplot(2, 1, 1), figure.add_subplot(2, 1, 2)

    mark_panels([upper, lower], [Panel("a", 2, "begin"), Panel("b", 6, "end")], dt=0.5)

    for axes in (upper, lower):
        assert [line.get_xdata()[0] for line in axes.lines] == [1.0, 3.0]
    assert [text.get_text() for text in upper.texts] == ["a", "b"]
    assert not lower.texts
