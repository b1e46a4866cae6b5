"""The picture: six panels of the evolving potential above the strengths of the paths."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.legend_handler import HandlerTuple
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from aicon_baselines.figures.nav2d.grid import grid_around
from aicon_baselines.figures.nav2d.recording import Recording
from aicon_baselines.figures.nav2d.strengths import draw_strengths
from aicon_baselines.figures.nav2d.style import (
    AGENT,
    BELIEF,
    EXPLORING,
    HEIGHT,
    MEAN_MARK,
    OBSTACLE,
    TARGET_MARK,
    TINT,
)
from aicon_baselines.figures.nav2d.view import View
from aicon_baselines.figures.pictures import OnStep, Panel, mark_panels, save_picture

_CAPTION = (
    "Arrows: direction of the resolved descent, sampled densely with the agent's memory of that moment; the clearance "
    "at other positions is the true one. Background: the potential whose slope fits\n"
    "these samples best (least squares). The agent itself computes only the gradient at its own position. "
    "One rollout of aicon/Nav2D-v0 with its noise."
)


def draw_rollout(
    recording: Recording, panels: Sequence[Panel], path: Path, spacing: float = 0.04, on_step: OnStep = lambda: None
) -> None:
    """Save the figure: six panels of the evolving potential, and the strengths of the paths over time.

    Args:
        recording: The rollout.
        panels: The moments to show.
        path: Where to save the picture.
        spacing: Distance of the sampled positions, m.
        on_step: Called after every panel.
    """
    figure = Figure(figsize=(14, 8), dpi=150)
    panels_at = {"left": 0.012, "right": 0.988, "top": 0.928, "bottom": 0.333, "hspace": 0.115, "wspace": 0.025}
    cells = figure.add_gridspec(2, 3, **panels_at)
    grid = grid_around(recording, spacing)
    for index, panel in enumerate(panels):
        view = View(figure.add_subplot(cells[index]), recording, grid)
        view.show(panel.step)
        view.outline()
        view.entitle(rf"$\mathbf{{{panel.letter}}}$   {panel.title}", size=11)
        on_step()
    strip = figure.add_axes((0.062, 0.118, 0.926, 0.147))
    draw_strengths(strip, recording)
    strip.legend(loc="lower left", bbox_to_anchor=(-0.01, 1.1), ncols=5, frameon=False, fontsize=10, columnspacing=1.8)
    for panel in panels:
        strip.axvline(recording.times[panel.step], color="0.25", linewidth=0.8, linestyle=(0, (2, 2)))
    mark_panels(strip, panels, recording.policy.model.dt)
    figure.legend(**_legend(), loc="upper center", bbox_to_anchor=(0.5, 1.004), ncols=7, frameon=False, fontsize=10)
    figure.text(0.012, 0.012, _CAPTION, fontsize=8.5, color="0.3", linespacing=1.35)
    save_picture(figure, path)


def _legend() -> dict[str, Any]:
    """Handles and labels of what the panels show."""
    trail = Line2D([], [], color=AGENT, linewidth=2.2)
    agent = Line2D([], [], color=AGENT, marker="o", markersize=8, markeredgecolor="white", linestyle="none")
    ellipse = Line2D(
        [], [], color=BELIEF, marker="o", markersize=13, markerfacecolor=to_rgba(BELIEF, 0.15), linestyle="none"
    )
    entries: list[tuple[Any, str]] = [
        ((trail, agent), "agent and its way"),
        (Line2D([], [], **TARGET_MARK), "target"),
        ((ellipse, Line2D([], [], **MEAN_MARK)), "believed target (2σ)"),
        (Patch(color=OBSTACLE), "obstacle"),
        (Patch(facecolor=to_rgba(EXPLORING, TINT), edgecolor=EXPLORING), "where it would explore"),
        (Patch(facecolor=HEIGHT(0.85)), "potential high"),
        (Patch(facecolor=HEIGHT(0.05), edgecolor="0.7"), "potential low"),
    ]
    return {
        "handles": [handle for handle, _ in entries],
        "labels": [label for _, label in entries],
        "handler_map": {tuple: HandlerTuple(ndivide=1)},
    }
