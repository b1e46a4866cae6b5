"""The panels of a figure: moments of an episode, and how they are drawn and marked."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.legend_handler import HandlerTuple

from aicon_baselines.evaluation.recording import track
from aicon_baselines.figures.view import WorldView

ROWS, COLUMNS = 2, 3
"""Panels of a figure."""

LABELS = "abcdef"
"""Labels of the panels, in order of time."""

_MARK: dict[str, Any] = {"color": "0.25", "linewidth": 0.8, "linestyle": (0, (2, 2))}


class Panel(NamedTuple):
    """One moment of an episode: its label, its step and what happens there, in plain words."""

    label: str
    step: int
    title: str


def increasing(steps: Sequence[int], last: int) -> list[int]:
    """The steps, moved where needed so that they increase strictly and lie within 1 to `last`."""
    moved: list[int] = []
    earliest = 1

    for index, step in enumerate(steps):
        latest = last - (len(steps) - 1 - index)  # leaves room for those that follow
        moved.append(min(max(step, earliest), latest))
        earliest = moved[-1] + 1

    return moved


def draw_panels(
    figure: Figure,
    panels: Sequence[Panel],
    make_view: Callable[[Axes], WorldView],
    area: Mapping[str, float],
    *,
    title_size: float,
    progress: bool,
) -> None:
    """Draw the world at the moment of each panel.

    Args:
        figure: Where to draw.
        panels: The panels, row by row.
        make_view: Makes the view of a panel.
        area: Edges of the area of all panels and gaps between them, as of `add_gridspec`.
        title_size: Size of the titles, pt.
        progress: Whether to show a progress bar, on a terminal only.
    """
    # One view a panel, at its own moment.
    cells = figure.add_gridspec(ROWS, COLUMNS, **area)

    for index, panel in enumerate(track(panels, "picture", progress)):
        view = make_view(figure.add_subplot(cells[index]))
        view.show(panel.step)
        view.set_title(rf"$\mathbf{{{panel.label}}}$   {panel.title}", title_size)


def mark_panels(timelines: Sequence[Axes], panels: Sequence[Panel], dt: float) -> None:
    """Mark the time of each panel in all timelines, and write its label above the first one.

    Args:
        timelines: The axes, from top to bottom.
        panels: The panels.
        dt: Time of a step, s.
    """
    for panel in panels:
        time = panel.step * dt
        for axes in timelines:
            axes.axvline(time, **_MARK)

        # Just above the axes, whatever their limits are.
        timelines[0].annotate(
            panel.label,
            (time, 1.0),
            (0, 2),
            ("data", "axes fraction"),
            textcoords="offset points",
            ha="center",
            fontsize=10,
            fontweight="bold",
        )


def add_legend(figure: Figure, entries: Mapping[str, Any], size: float) -> None:
    """Explain above all panels, in one row, what they show.

    Args:
        figure: The figure.
        entries: The handle of each label; a tuple of handles is drawn as one.
        size: Size of the text, pt.
    """
    figure.legend(
        handles=list(entries.values()),
        labels=list(entries),
        handler_map={tuple: HandlerTuple(ndivide=1)},
        loc="upper center",
        bbox_to_anchor=(0.5, 1.004),
        ncols=len(entries),
        frameon=False,
        fontsize=size,
    )


def add_caption(figure: Figure, text: str, height: float, size: float) -> None:
    """Write a caption at the lower left, at a height in shares of the figure, in pt."""
    figure.text(0.012, height, text, fontsize=size, color="0.3", linespacing=1.35)
