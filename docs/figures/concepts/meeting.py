"""Gradients that meet: the same two goals, at three places."""

from pathlib import Path

import numpy as np

from concepts import drawing
from concepts.world import Wall, meeting_at

TARGET = (1.6, 0.0)
WALL = Wall((0.45, -0.62), (0.45, 0.62))
PLACES = {
    "They agree: past the wall": (0.72, 0.1),
    "They are at right angles: beside it": (0.72, 0.88),
    "They oppose each other: in front of it": (0.1, 0.0),
}
_LENGTH = 0.5
"""Length of an arrow for a gradient of strength 1, m."""

_SIDES = {"reach": (0.34, -0.22), "avoid": (0.0, 0.12)}
"""Where the words stand beside an arrow's tip, m."""


def draw(path: Path) -> None:
    """Save the picture."""
    panels = drawing.new_figure(3)
    for axes, (title, position) in zip(panels, PLACES.items(), strict=True):
        drawing.as_world(axes, WALL, TARGET, x=(-0.7, 1.8), y=(-0.8, 1.5), title=title)

        # What each goal wants: down its gradient.
        place = np.array(position)
        wants = drawing.wants_of(meeting_at(place, TARGET, WALL))
        for goal, descent in wants.items():
            color, strength = drawing.PATHS[goal], float(np.linalg.norm(descent))
            drawing.draw_arrow(axes, place, _LENGTH * descent, color, width=1.5 + 1.5 * strength)

            x, y = place + _LENGTH * descent + _SIDES[goal]
            axes.text(x, y, f"{goal} {strength:.2f}", color=color, ha="center")
        drawing.draw_robot(axes, place)

        first, second = (descent / np.linalg.norm(descent) for descent in wants.values())
        drawing.note(axes, f"cosine {first @ second:+.2f}")
    drawing.save(panels, path)
