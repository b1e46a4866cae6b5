"""The panels of a rollout: their order, and their marks over time."""

import pytest
from matplotlib.figure import Figure

from aicon_baselines.evaluation.recording import runs_of
from aicon_baselines.figures.rollout import Panel, mark_panels


@pytest.mark.parametrize(
    ("items", "runs"), [("", []), ("aab", [(0, 2), (2, 3)]), ("aba", [(0, 1), (1, 2), (2, 3)])]
)
def test_runs_of_equal_items(items: str, runs: list[tuple[int, int]]) -> None:
    assert runs_of(items) == runs


def test_marks_stand_at_the_times_of_the_panels() -> None:
    figure = Figure()
    upper, lower = figure.add_subplot(2, 1, 1), figure.add_subplot(2, 1, 2)

    mark_panels([upper, lower], [Panel("a", 2, "begin"), Panel("b", 6, "end")], dt=0.5)

    for axes in (upper, lower):
        assert [line.get_xdata()[0] for line in axes.lines] == [1.0, 3.0]
    assert [text.get_text() for text in upper.texts] == ["a", "b"]
    assert not lower.texts
