"""Gradients that meet: the same two goals, at three places."""

from pathlib import Path

import numpy as np

from aicon_baselines.figures.concepts import drawing
from aicon_baselines.figures.concepts.world import Wall, meeting_at
from aicon_baselines.figures.recording import to_array

TARGET = (1.6, 0.0)
WALL = Wall((0.45, -0.62), (0.45, 0.62))
PLACES = {
    "They agree: past the wall": (0.72, 0.1),
    "They are at right angles: beside it": (0.72, 0.88),
    "They oppose each other: in front of it": (0.1, 0.0),
}
_SIDES = {"reach": (0.34, -0.22), "avoid": (0.0, 0.12)}
"""Where the words stand beside an arrow's tip, m."""


def draw(path: Path) -> None:
    """Save the picture."""
    panels = drawing.new_figure(3)
    for axes, (title, position) in zip(panels, PLACES.items(), strict=True):
        place = np.array(position)
        drawing.as_world(axes, x=(-0.7, 1.8), y=(-0.8, 1.5), title=title)
        drawing.draw_wall(axes, WALL)
        drawing.draw_target(axes, TARGET)

        # What each goal wants: down its gradient.
        meeting = meeting_at(place, TARGET, WALL)
        descents, strengths = -to_array(meeting.gradients), to_array(meeting.strengths)
        for goals, descent, strength in zip(meeting.goals, descents, strengths, strict=True):
            color = drawing.PATHS[goals[0]]
            drawing.draw_arrow(axes, place, 0.5 * descent, color, width=1.5 + 1.5 * strength)
            side = _SIDES[goals[0]]
            tip = place + 0.5 * descent + side
            drawing.label(axes, tip, f"{goals[0]} {strength:.2f}", color, ha="center")
        drawing.draw_robot(axes, place)

        first, second = descents / np.linalg.norm(descents, axis=1, keepdims=True)
        drawing.note(axes, f"cosine {first @ second:+.2f}")
    drawing.save(panels, path)
