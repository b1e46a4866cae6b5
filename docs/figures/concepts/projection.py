"""What projection does: the weaker gradient loses its component along the stronger one."""

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from aicon_baselines import palette
from aicon_baselines.evaluation.recording import FloatArray
from concepts import drawing
from concepts.world import Wall, meeting_at

PLACE, TARGET = np.array([0.0, 0.0]), (1.75, 0.6)
WALL = Wall((-0.6, 0.38), (0.3, 0.38))


def draw(path: Path) -> None:
    """Save the picture: two gradients, the weaker one projected, and both sums."""
    wants = drawing.wants_of(meeting_at(PLACE, TARGET, WALL))
    stronger, weaker = sorted(wants, key=lambda goal: -np.linalg.norm(wants[goal]))
    strong, weak = wants[stronger], wants[weaker]

    # What the weaker one loses, and what is left of it.
    along = (weak @ strong) / (strong @ strong) * strong
    left = weak - along

    panels = drawing.new_figure(3)
    titles = ("Two gradients meet", "The weaker one is projected", "What comes of it")
    for axes, title in zip(panels, titles, strict=True):
        drawing.as_world(axes, WALL, TARGET, x=(-0.75, 2.05), y=(-1.3, 0.85), title=title)
        drawing.draw_robot(axes, PLACE)
    first, second, third = panels
    strong_color, weak_color = drawing.PATHS[stronger], drawing.PATHS[weaker]

    # 1. Both, as they are.
    _arrow(first, strong, strong_color, f"{stronger}, the stronger", (-0.3, -0.2))
    _arrow(first, weak, weak_color, f"{weaker}, the weaker", (0.08, -0.02))

    # 2. The weaker one without its component along the stronger one.
    _arrow(second, strong, strong_color)
    _arrow(second, weak, weak_color, alpha=0.25)
    _arrow(second, left, weak_color, "what is left of it", (0.08, -0.06))
    drawing.draw_arrow(second, weak, -along, palette.PALE, width=1.2, linestyle=(0, (3, 2)))
    x, y = weak - (0.3, 0.18)
    second.text(x, y, "along the stronger one: gone", color=palette.PALE)

    # 3. The sum without projection and with it, and how much of the stronger one they keep.
    plain, projected = strong + weak, strong + left
    _arrow(third, strong, strong_color, alpha=0.3)
    _arrow(third, plain, palette.PALE, "plain sum", (0.02, -0.14))
    _arrow(third, projected, drawing.RESULT, "projected sum", (-0.25, 0.12))
    kept = [100 * (total @ strong) / (strong @ strong) for total in (plain, projected)]
    drawing.note(
        third,
        f"Of what {stronger} wants, the plain sum\nkeeps {kept[0]:.0f} %, "
        f"the projected one {kept[1]:.0f} %.",
    )
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
    x, y = PLACE + vector + side
    axes.text(x, y, words, color=color)
