"""The picture: six moments of an episode above its pose error and its gradients' strengths."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from aicon_baselines import palette
from aicon_baselines.figures.panels import (
    Panel,
    add_caption,
    add_legend,
    draw_panels,
    mark_panels,
)
from aicon_baselines.figures.pusht.recording import PushRecording
from aicon_baselines.figures.pusht.timeline import add_timelines
from aicon_baselines.figures.pusht.view import PushView
from aicon_baselines.figures.rendering import save_picture
from aicon_baselines.figures.timeline import add_curve_legend
from aicon_baselines.worlds.surroundings import GOAL_TINT

_PANELS = {
    "left": 0.012,
    "right": 0.988,
    "top": 0.937,
    "bottom": 0.33,
    "hspace": 0.1,
    "wspace": 0.025,
}
_COST, _STRENGTHS = (0.068, 0.19, 0.92, 0.085), (0.068, 0.093, 0.92, 0.085)
_CAPTION = (
    "Coloured arrows: descent directions of the strongest gradients that meet at the pusher, one "
    "for each contact; the wider, the stronger. Dots: their contacts, the larger, the likelier.\n"
    "Large arrow: the motion commanded for the next 0.1 s. Purple ground: it explores. One episode "
    "of aicon/PushT-v0."
)


def draw_rollout(
    recording: PushRecording, panels: Sequence[Panel], path: Path, *, progress: bool = False
) -> None:
    """Save the figure: six moments above the pose error and the strengths of the gradients.

    Args:
        recording: The episode.
        panels: The moments to show.
        path: Where to save the picture.
        progress: Whether to show a progress bar, on a terminal only.
    """
    # The world.
    figure = Figure(figsize=(14, 10.2), dpi=130)

    def make_view(axes: Axes) -> PushView:
        return PushView(axes, recording)

    draw_panels(figure, panels, make_view, _PANELS, title_size=12, progress=progress)

    # Two curves over the same time: the panels' labels are above the upper one, the axis' below the
    # lower one.
    timelines = add_timelines(figure, recording, _COST, _STRENGTHS)
    for axes in timelines:
        axes.yaxis.set_label_coords(-0.04, 0.5)
    cost, strengths = timelines
    cost.tick_params(labelbottom=False)
    mark_panels(timelines, panels, recording.time_step)
    add_curve_legend(
        strengths,
        loc="upper right",
        bbox_to_anchor=(1.005, 2.72),
        ncols=4,
        fontsize=11,
        columnspacing=1.8,
    )

    # How to read it: marks above the panels, words below the timeline.
    add_legend(figure, _legend_entries(), size=11)
    add_caption(figure, _CAPTION, height=0.01, size=9)
    save_picture(figure, path)


def _legend_entries() -> dict[str, Any]:
    """Label and handle of what the panels show."""
    trail = Line2D([], [], color=to_rgba(palette.ROBOT, 0.6), linewidth=2.2)
    goal_area = to_rgba(palette.GOAL, GOAL_TINT)

    return {
        "pusher and its way": (trail, _dot(palette.ROBOT, 10)),
        "object": Patch(facecolor=palette.OBJECT, edgecolor=palette.OUTLINE),
        "goal pose": Patch(facecolor=goal_area, edgecolor=palette.GOAL, linewidth=2),
        "useful contact, its gradient": _contact(palette.TOWARDS),
        "detrimental contact, its gradient": _contact(palette.AWAY),
        "commanded motion": Patch(facecolor=palette.MOTION, edgecolor=palette.INK, linewidth=1.5),
    }


def _contact(color: str) -> tuple[Line2D, Line2D]:
    """A contact and its gradient."""
    return Line2D([], [], color=color, linewidth=2.5), _dot(color, 8)


def _dot(color: str, size: float) -> Line2D:
    return Line2D(
        [], [], color=color, marker="o", markersize=size, markeredgecolor="white", linestyle="none"
    )
