"""What opposing gradients do: where they cancel, a sum stays."""

from pathlib import Path

import numpy as np

from aicon_baselines.figures.concepts import drawing
from aicon_baselines.figures.concepts.world import Wall, make_policy, meeting_at, run
from aicon_baselines.figures.recording import to_array
from aicon_baselines.figures.timeline import simplify
from aicon_torch import DirectDescent, Sum

START, TARGET = (-1.6, 0.0), (1.3, 0.0)
WALL = Wall((0.0, -0.7), (0.0, 0.8))


def draw(path: Path) -> None:
    """Save the picture."""
    world, curves = drawing.new_figure(2, height=3.9, widths=(1.45, 1), below=0.5)

    # The way of a robot that adds its gradients up.
    policy = make_policy(Sum(), DirectDescent(gain=5.0, smoothing=0.0))
    way = run(policy, START, TARGET, WALL, steps=120)
    drawing.as_world(world, x=(-1.85, 1.6), y=(-1.15, 1.4), title="The sum of both: it stays here")
    drawing.draw_wall(world, WALL)
    drawing.draw_target(world, TARGET)
    world.plot(*way.places.T, color=drawing.RESULT, linewidth=2.4)

    end = way.places[-1]
    for goals, descent in zip(
        way.meetings[-1].goals, -to_array(way.meetings[-1].gradients), strict=True
    ):
        drawing.draw_arrow(world, end, 0.45 * descent, drawing.PATHS[goals[0]])
    drawing.draw_robot(world, end)
    drawing.note(world, "What “reach” wants and what “avoid” wants cancel.")

    # How strong both are on the way to the wall.
    gaps = np.linspace(0.02, 1.2, 60)
    meetings = [meeting_at(np.array([-gap, 0.0]), TARGET, WALL) for gap in gaps]
    strengths = np.array([to_array(meeting.strengths) for meeting in meetings])
    for goals, strength in zip(meetings[0].goals, strengths.T, strict=True):
        color = drawing.PATHS[goals[0]]
        curves.plot(gaps, strength, color=color, linewidth=2.2, label=goals[0])

    curves.axvline(-end[0], color=drawing.RESULT, linewidth=1.2, linestyle=(0, (3, 2)))
    curves.annotate(
        "equally strong:\nthe sum is zero",
        (-end[0], 1.0),
        (1.12, 1.3),
        fontsize=10,
        arrowprops={"arrowstyle": "-", "color": drawing.RESULT},
    )
    curves.set_title("How strong they are", fontsize=11, loc="left")
    curves.set(xlabel="distance to the wall, m", ylabel="strength", xlim=(1.2, 0.0))
    curves.legend(frameon=False, fontsize=10, loc="lower left")
    simplify(curves)
    drawing.save([world, curves], path)
