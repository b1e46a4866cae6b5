"""What exploration does: along the wall, while the conflict lasts."""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from aicon_baselines import palette
from aicon_baselines.evaluation.recording import true_intervals
from aicon_baselines.figures.timeline import SHADE, simplify
from aicon_torch import DirectDescent, Exploration
from concepts import drawing
from concepts.conflict import AREA, START, TARGET, WALL
from concepts.world import DT, Way, make_policy, run


def draw(path: Path) -> None:
    """Save the picture."""
    world, curves = drawing.new_figure(2, height=3.9, widths=(1.45, 1), below=0.5)
    way = run(make_policy(law=DirectDescent()), START, TARGET, WALL, steps=300)

    title = "Explore where they cancel: it gets around"
    drawing.as_world(world, WALL, TARGET, **AREA, title=title)
    _draw_way(world, way)
    _draw_moment(world, way)
    _draw_cosine(curves, way)

    drawing.save([world, curves], path)


def _draw_way(axes: Axes, way: Way) -> None:
    """The way, violet where it explored."""
    axes.plot(*way.places.T, color=drawing.RESULT, linewidth=2.4)
    for begin, end in true_intervals(np.array(way.exploring)):
        axes.plot(*way.places[begin : end + 1].T, color=drawing.EXPLORES, linewidth=4)
    drawing.draw_robot(axes, way.places[-1])
    drawing.note(axes, "Violet: it moves in the nullspace of the stronger gradient.")


def _draw_moment(axes: Axes, way: Way) -> None:
    """The gradients in the middle of the exploration, and the direction that it takes."""
    explored = np.flatnonzero(way.exploring)
    step = int(explored[len(explored) // 2])
    place, meeting = way.places[step], way.meetings[step]
    drawing.draw_wants(axes, place, meeting, length=0.4, width=2.2)

    motion = way.places[step + 1] - place
    drawing.draw_arrow(axes, place, 0.5 * motion / np.linalg.norm(motion), drawing.EXPLORES)
    axes.plot(*place, "o", color="white", markeredgecolor=drawing.EXPLORES, markersize=9, zorder=6)


def _draw_cosine(axes: Axes, way: Way) -> None:
    """The cosine of the two, and where a conflict begins and ends."""
    times = DT * np.arange(len(way.meetings))
    axes.plot(times, [float(meeting.cosine) for meeting in way.meetings], color=palette.INK)
    for begin, end in true_intervals(np.array(way.exploring)):
        axes.axvspan(DT * begin, DT * end, **SHADE)

    bounds = Exploration()
    limits = {"a conflict begins below": bounds.enter_cosine, "and ends above": bounds.exit_cosine}
    for words, bound in limits.items():
        axes.axhline(bound, color=palette.PALE, linewidth=1, linestyle=(0, (3, 2)))
        looks: dict[str, Any] = {"ha": "right", "fontsize": 9, "color": "0.35"}
        axes.text(times[-1] - 0.1, bound + 0.04, f"{words} {bound:g}", **looks)
    axes.set(xlabel="time, s", ylabel="cosine of the two", ylim=(-1.1, 1.1), xlim=(0, times[-1]))
    axes.set_title("How much they oppose each other", fontsize=11, loc="left")
    simplify(axes)
