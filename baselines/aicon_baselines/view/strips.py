"""Curves over the last seconds: how strong the gradients are, whether they agree, what is left."""

from collections import deque
from collections.abc import Mapping

import numpy as np

from aicon_baselines.view.marks import FloatArray
from aicon_baselines.view.server import viser

_KEPT = 400  # moments that a strip shows


class Strip:
    """A diagram of some curves over time.

    Args:
        gui: Where to add it.
        title: What it shows.
        curves: The curves with their colours.
    """

    def __init__(self, gui: viser.GuiApi, title: str, curves: Mapping[str, str]) -> None:
        self._names = tuple(curves)
        self._moments: deque[list[float]] = deque(maxlen=_KEPT)

        series: list[viser.uplot.Series] = [{"label": "s"}]
        for name, color in curves.items():
            series.append({"label": name, "stroke": color, "width": 1.5})

        self._plot = gui.add_uplot(
            self._data(),
            tuple(series),
            title=title,
            height=160,
            scales={"x": {"time": False}},
            axes=({"size": 34}, {"size": 50}),
            legend={"show": True, "live": False},
        )

    def clear(self) -> None:
        """Begin anew."""
        self._moments.clear()
        self._plot.data = self._data()

    def add(self, time: float, values: Mapping[str, float]) -> None:
        """Add the values of a moment, s; a curve that has none is interrupted."""
        self._moments.append([time, *(values.get(name, np.nan) for name in self._names)])

    def show(self) -> None:
        """Bring the page up to date."""
        self._plot.data = self._data()

    def _data(self) -> tuple[FloatArray, ...]:
        """The times, then each curve."""
        moments = list(self._moments) or [[0.0] * (1 + len(self._names))]
        return tuple(np.array(moments, np.float64).T.copy())
