"""Legends over time: the curves from the highest to the lowest, and then the explorations."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from aicon_baselines.figures.timeline import TimeCursor, curve_handles, gaps_at_zero


def axes_with_curves() -> Axes:
    axes = Figure().add_subplot()
    axes.plot([0, 1, 2], [1.0, 9.0, 1.0], label="low, with a peak")
    axes.plot([0, 1, 2], [np.nan, np.nan, np.nan], label="nothing")
    axes.plot([0, 1, 2], [np.nan, 5.0, 5.0], label="high")
    return axes


def test_legend_is_in_the_order_of_the_curves() -> None:
    labels = [handle.get_label() for handle in curve_handles([axes_with_curves()])]
    assert labels == ["high", "low, with a peak", "nothing", "exploring"]


def test_values_that_a_logarithm_does_not_have_are_gaps() -> None:
    np.testing.assert_equal(gaps_at_zero(np.array([0.0, 2.0])), [np.nan, 2.0])


def test_cursor_moves_in_all_timelines() -> None:
    figure = Figure()
    timelines = [figure.add_subplot(2, 1, 1), figure.add_subplot(2, 1, 2)]
    cursor = TimeCursor(timelines, "black")

    cursor.move(1.5)

    assert [axes.lines[0].get_xdata() for axes in timelines] == [[1.5], [1.5]]
