"""What projection does: the weaker gradient loses its component along the stronger one."""

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from aicon_baselines.figures.concepts import drawing
from aicon_baselines.figures.concepts.world import Wall, meeting_at
from aicon_baselines.figures.recording import FloatArray, to_array

PLACE, TARGET = np.array([0.0, 0.0]), (1.75, 0.6)
WALL = Wall((-0.6, 0.38), (0.3, 0.38))


def draw(path: Path) -> None:
    """Save the picture."""
    meeting = meeting_at(PLACE, TARGET, WALL)
    descents = -to_array(meeting.gradients)
    leader = int(meeting.leader)
    strong, weak = descents[leader], descents[1 - leader]
    colors = [drawing.PATHS[goals[0]] for goals in meeting.goals]
    names = [goals[0] for goals in meeting.goals]

    # The component of the weaker one along the stronger one, and what is left of it.
    direction = strong / np.linalg.norm(strong)
    along = (weak @ direction) * direction
    left = weak - along

    panels = drawing.new_figure(3)
    titles = ("Two gradients meet", "The weaker one is projected", "What comes of it")
    for axes, title in zip(panels, titles, strict=True):
        drawing.as_world(axes, x=(-0.75, 2.05), y=(-1.3, 0.85), title=title)
        drawing.draw_wall(axes, WALL)
        drawing.draw_target(axes, TARGET)

    _arrow(panels[0], strong, colors[leader], f"{names[leader]}, the stronger", (-0.3, -0.2))
    _arrow(panels[0], weak, colors[1 - leader], f"{names[1 - leader]}, the weaker", (0.08, -0.02))

    _arrow(panels[1], strong, colors[leader])
    _arrow(panels[1], weak, colors[1 - leader], alpha=0.25)
    _arrow(panels[1], left, colors[1 - leader], "what is left of it", (0.08, -0.06))
    drawing.draw_arrow(panels[1], weak, -along, drawing.PALE, width=1.2, linestyle=(0, (3, 2)))
    drawing.label(panels[1], weak - (0.3, 0.18), "along the stronger one: gone", drawing.PALE)

    total, resolved = strong + weak, strong + left
    _arrow(panels[2], strong, colors[leader], alpha=0.3)
    _arrow(panels[2], total, drawing.PALE, "plain sum", (0.02, -0.14))
    _arrow(panels[2], resolved, drawing.RESULT, "projected sum", (-0.25, 0.12))
    shares = [vector @ direction / np.linalg.norm(strong) for vector in (total, resolved)]
    drawing.note(
        panels[2],
        f"Of what {names[leader]} wants, the plain sum\nkeeps {shares[0]:.0%}, the projected one "
        f"{shares[1]:.0%}.".replace("%", " %"),
    )
    for axes in panels:
        drawing.draw_robot(axes, PLACE)
    drawing.save(panels, path)


def _arrow(
    axes: Axes,
    vector: FloatArray,
    color: str,
    words: str = "",
    side: tuple[float, float] = (0.0, 0.0),
    alpha: float = 1.0,
) -> None:
    """An arrow from the robot, with words at some place beside its tip."""
    drawing.draw_arrow(axes, PLACE, vector, color, alpha=alpha)
    if words:
        drawing.label(axes, PLACE + vector + side, words, color)
