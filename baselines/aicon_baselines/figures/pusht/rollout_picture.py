"""The picture: six moments of an episode above its pose error and the strengths of its gradients."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.legend_handler import HandlerTuple
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from aicon_baselines.figures.pictures import OnStep, Panel, mark_panels, save_picture
from aicon_baselines.figures.pusht.recording import Recording
from aicon_baselines.figures.pusht.strip import draw_cost, draw_strengths
from aicon_baselines.figures.pusht.style import (
    DETRIMENTAL,
    GOAL,
    GOAL_TINT,
    INK,
    MOTION,
    OBJECT,
    OUTLINE,
    PUSHER,
    USEFUL,
)
from aicon_baselines.figures.pusht.view import View

_CAPTION = (
    "Coloured arrows: descent directions of the strongest gradients that meet at the pusher, one for each contact; "
    "the wider, the stronger. Dots: their contacts, the larger, the likelier.\n"
    "Large arrow: the motion commanded for the next 0.1 s. Purple ground: it explores. One episode of aicon/PushT-v0."
)


def draw_rollout(recording: Recording, panels: Sequence[Panel], path: Path, on_step: OnStep = lambda: None) -> None:
    """Save the figure: six moments, and the pose error and the strengths of the gradients over time.

    Args:
        recording: The episode.
        panels: The moments to show.
        path: Where to save the picture.
        on_step: Called after every panel.
    """
    figure = Figure(figsize=(14, 10.2), dpi=130)
    panels_at = {"left": 0.012, "right": 0.988, "top": 0.937, "bottom": 0.33, "hspace": 0.1, "wspace": 0.025}
    cells = figure.add_gridspec(2, 3, **panels_at)
    for index, panel in enumerate(panels):
        view = View(figure.add_subplot(cells[index]), recording)
        view.show(panel.step)
        view.entitle(rf"$\mathbf{{{panel.letter}}}$   {panel.title}", size=12)
        on_step()
    cost, strengths = figure.add_axes((0.068, 0.19, 0.92, 0.085)), figure.add_axes((0.068, 0.093, 0.92, 0.085))
    draw_cost(cost, recording)
    cost.tick_params(labelbottom=False)
    draw_strengths(strengths, recording)
    for axes in (cost, strengths):
        axes.yaxis.set_label_coords(-0.04, 0.5)
        for panel in panels:
            axes.axvline(recording.times[panel.step], color="0.25", linewidth=0.8, linestyle=(0, (2, 2)))
    mark_panels(cost, panels, recording.policy.model.dt)
    figure.legend(**_legend(), loc="upper center", bbox_to_anchor=(0.5, 1.004), ncols=6, frameon=False, fontsize=11)
    strengths.legend(
        loc="upper right", bbox_to_anchor=(1.005, 2.72), ncols=4, frameon=False, fontsize=11, columnspacing=1.8
    )
    figure.text(0.012, 0.01, _CAPTION, fontsize=9, color="0.3", linespacing=1.35)
    save_picture(figure, path)


def _legend() -> dict[str, Any]:
    """Handles and labels of what the panels show."""
    trail = Line2D([], [], color=to_rgba(PUSHER, 0.6), linewidth=2.2)
    disc = Line2D([], [], color=PUSHER, marker="o", markersize=10, markeredgecolor="white", linestyle="none")
    entries: list[tuple[Any, str]] = [
        ((trail, disc), "pusher and its way"),
        (Patch(facecolor=OBJECT, edgecolor=OUTLINE), "object"),
        (Patch(facecolor=to_rgba(GOAL, GOAL_TINT), edgecolor=GOAL, linewidth=2), "goal pose"),
        (_contact(USEFUL), "useful contact, its gradient"),
        (_contact(DETRIMENTAL), "detrimental contact, its gradient"),
        (Patch(facecolor=MOTION, edgecolor=INK, linewidth=1.5), "commanded motion"),
    ]
    return {
        "handles": [handle for handle, _ in entries],
        "labels": [label for _, label in entries],
        "handler_map": {tuple: HandlerTuple(ndivide=1)},
    }


def _contact(colour: str) -> Any:
    dot = Line2D([], [], color=colour, marker="o", markersize=8, markeredgecolor="white", linestyle="none")
    return Line2D([], [], color=colour, linewidth=2.5), dot
