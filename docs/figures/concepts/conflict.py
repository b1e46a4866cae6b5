"""What opposing gradients do: where they cancel, a sum stays."""

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from aicon_baselines.evaluation.recording import FloatArray, to_array
from aicon_baselines.figures.timeline import simplify
from aicon_torch import DirectDescent, Sum
from concepts import drawing
from concepts.world import Wall, Way, make_policy, meeting_at, run

START, TARGET = (-1.6, 0.0), (1.3, 0.0)
WALL = Wall((0.0, -0.7), (0.0, 0.8))
AREA = {"x": (-1.85, 1.6), "y": (-1.15, 1.4)}
"""What is shown of the world, m."""


def draw(path: Path) -> None:
    """Save the picture."""
    world, curves = drawing.new_figure(2, height=3.9, widths=(1.45, 1), below=0.5)

    # A robot that adds its gradients up.
    policy = make_policy(Sum(), DirectDescent(gain=5.0, smoothing=0.0))
    way = run(policy, START, TARGET, WALL, steps=120)

    _draw_way(world, way)
    _draw_strengths(curves, end=way.places[-1])
    drawing.save([world, curves], path)


def _draw_way(axes: Axes, way: Way) -> None:
    """Its way to where it stays, and what both goals want there."""
    title = "The sum of both: it stays here"
    drawing.as_world(axes, WALL, TARGET, **AREA, title=title)
    axes.plot(*way.places.T, color=drawing.RESULT, linewidth=2.4)

    end = way.places[-1]
    drawing.draw_wants(axes, end, way.meetings[-1], length=0.45)
    drawing.draw_robot(axes, end)
    drawing.note(axes, "What “reach” wants and what “avoid” wants cancel.")


def _draw_strengths(axes: Axes, end: FloatArray) -> None:
    """How strong both are on the way to the wall, and where that way ends."""
    gaps = np.linspace(0.02, 1.2, 60)
    meetings = [meeting_at(np.array([-gap, 0.0]), TARGET, WALL) for gap in gaps]
    strengths = np.array([to_array(meeting.magnitudes) for meeting in meetings])
    for (goal,), strength in zip(meetings[0].goals, strengths.T, strict=True):
        axes.plot(gaps, strength, color=drawing.PATHS[goal], linewidth=2.2, label=goal)

    gap = -float(end[0])
    axes.axvline(gap, color=drawing.RESULT, linewidth=1.2, linestyle=(0, (3, 2)))
    axes.annotate(
        "equally strong:\nthe sum is zero",
        (gap, 1.0),
        (1.12, 1.3),
        fontsize=10,
        arrowprops={"arrowstyle": "-", "color": drawing.RESULT},
    )

    axes.set_title("How strong they are", fontsize=11, loc="left")
    axes.set(xlabel="distance to the wall, m", ylabel="strength", xlim=(1.2, 0.0))
    axes.legend(frameon=False, fontsize=10, loc="lower left")
    simplify(axes)
