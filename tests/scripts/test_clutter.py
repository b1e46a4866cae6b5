"""How the share of problems that are solved is drawn over time."""

from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure

from clutter import draw_shares


class Solved(NamedTuple):
    policy: str
    time: float
    is_solved: bool


def test_a_policy_that_solves_nothing_is_drawn_at_zero() -> None:
    rows = [Solved("one", 4.0, True), Solved("one", np.nan, False), Solved("other", np.nan, False)]
    axes = Figure().subplots()

    draw_shares(axes, rows, horizon=10.0)
    curves = [line.get_xydata() for line in axes.get_lines()]
    np.testing.assert_array_equal(curves[0], [(0, 0), (4, 50), (10, 50)])
    np.testing.assert_array_equal(curves[1], [(0, 0), (10, 0)])
