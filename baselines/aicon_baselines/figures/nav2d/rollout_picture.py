"""The picture: six panels of the evolving potential above the strengths of the paths."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from aicon_baselines import palette
from aicon_baselines.figures.nav2d import style
from aicon_baselines.figures.nav2d.grid import grid_around
from aicon_baselines.figures.nav2d.recording import NavigationRecording
from aicon_baselines.figures.nav2d.timeline import draw_strengths
from aicon_baselines.figures.nav2d.view import NavigationView
from aicon_baselines.figures.panels import (
    Panel,
    add_caption,
    add_legend,
    draw_panels,
    mark_panels,
)
from aicon_baselines.figures.rendering import save_picture
from aicon_baselines.figures.style import TARGET_MARK
from aicon_baselines.figures.timeline import add_curve_legend

_PANELS = {
    "left": 0.012,
    "right": 0.988,
    "top": 0.928,
    "bottom": 0.333,
    "hspace": 0.115,
    "wspace": 0.025,
}
_TIMELINE = (0.062, 0.118, 0.926, 0.147)
_CAPTION = (
    "Arrows: direction of the resolved descent, sampled densely with the agent's memory of that "
    "moment; the clearance at other positions is the true one. Background: the potential whose "
    "slope fits\nthese samples best (least squares). The agent itself computes only the gradient "
    "at its own position. One rollout of aicon/Nav2D-v0 with its noise."
)


def draw_rollout(
    recording: NavigationRecording,
    panels: Sequence[Panel],
    path: Path,
    spacing: float = 0.04,
    *,
    progress: bool = False,
) -> None:
    """Save the figure: six panels of the evolving potential above the strengths of the paths.

    Args:
        recording: The rollout.
        panels: The moments to show.
        path: Where to save the picture.
        spacing: Distance of the sampled positions, m.
        progress: Whether to show a progress bar, on a terminal only.
    """
    # The world, with one grid for all panels: they show the same section of it.
    figure = Figure(figsize=(14, 8), dpi=150)
    grid = grid_around(recording, spacing)

    def make_view(axes: Axes) -> NavigationView:
        return NavigationView(axes, recording, grid, outline=True)

    draw_panels(figure, panels, make_view, _PANELS, title_size=11, progress=progress)

    # Over time, with the panels' labels above.
    timeline = figure.add_axes(_TIMELINE)
    draw_strengths(timeline, recording)
    mark_panels([timeline], panels, recording.time_step)
    add_curve_legend(
        timeline,
        loc="lower left",
        bbox_to_anchor=(-0.01, 1.1),
        ncols=5,
        fontsize=10,
        columnspacing=1.8,
    )

    # How to read it: marks above the panels, words below the timeline.
    add_legend(figure, _legend_entries(), size=10)
    add_caption(figure, _CAPTION, height=0.012, size=8.5)
    save_picture(figure, path)


def _legend_entries() -> dict[str, Any]:
    """Label and handle of what the panels show."""
    trail = Line2D([], [], color=palette.ROBOT, linewidth=2.2)
    disc = Line2D(
        [],
        [],
        color=palette.ROBOT,
        marker="o",
        markersize=8,
        markeredgecolor="white",
        linestyle="none",
    )

    ellipse = Line2D(
        [],
        [],
        color=palette.BELIEF,
        marker="o",
        markersize=13,
        markerfacecolor=to_rgba(palette.BELIEF, 0.15),
        linestyle="none",
    )
    mean = Line2D([], [], **style.MEAN_MARK)
    tint = to_rgba(palette.EXPLORING, style.TINT)

    return {
        "agent and its way": (trail, disc),
        "target": Line2D([], [], **TARGET_MARK),
        "believed target (2σ)": (ellipse, mean),
        "obstacle": Patch(color=palette.OBSTACLE),
        "where it would explore": Patch(facecolor=tint, edgecolor=palette.EXPLORING),
        "potential high": Patch(facecolor=style.HEIGHT(0.85)),
        "potential low": Patch(facecolor=style.HEIGHT(0.05), edgecolor="0.7"),
    }
