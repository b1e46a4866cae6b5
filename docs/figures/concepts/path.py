"""What a path is: from a goal back to the actuator, one derivative after the other."""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import FancyBboxPatch

from aicon_baselines import palette
from concepts import drawing
from concepts.world import MEETING, make_policy

_WIDTH, _HEIGHT = 1.5, 0.56


class _Box(NamedTuple):
    """A quantity or goal: where it stands, and what stands in it."""

    x: float
    y: float
    words: str


_BOXES = {
    "reach": _Box(0.0, 1.15, "reach\n‖target‖"),
    "avoid": _Box(0.0, 0.0, "avoid\nhinge(wall)"),
    "target": _Box(2.9, 1.15, "target\nrelative place"),
    "wall": _Box(2.9, 0.0, "wall\nnearest point"),
    MEETING: _Box(5.8, 0.575, "x\none step's way"),
    "a": _Box(8.4, 0.575, "a\nvelocity"),
}
_EDGES = {
    ("reach", "target"): (drawing.REACH, "∂reach/∂target"),
    ("avoid", "wall"): (drawing.AVOID, "∂avoid/∂wall"),
    ("target", MEETING): (drawing.REACH, "∂target/∂x"),
    ("wall", MEETING): (drawing.AVOID, "∂wall/∂x"),
    (MEETING, "a"): (drawing.RESULT, "∂x/∂a"),
}


def draw(path: Path) -> None:
    """Save the picture."""
    (axes,) = drawing.new_figure(1, height=2.9)
    axes.set(xlim=(-0.9, 9.3), ylim=(-0.75, 1.75), aspect="equal")
    axes.axis("off")

    for name, box in _BOXES.items():
        _draw_box(axes, box, meets=name == MEETING)
    for (source, target), (color, words) in _EDGES.items():
        _draw_edge(axes, _BOXES[source], _BOXES[target], color, words)

    # The paths, as the model itself lists them.
    policy = make_policy()
    listed = [str(one).replace("\n", "") for one in policy.model.paths()]
    words = "Two paths:   " + "      ".join(listed)
    axes.text(-0.75, -0.66, words, fontsize=10.5, color="0.25")
    axes.text(5.8, 1.1, "here they meet", ha="center", fontsize=10.5, color=drawing.RESULT)
    drawing.save([axes], path)


def _draw_box(axes: Axes, box: _Box, *, meets: bool) -> None:
    corner = (box.x - _WIDTH / 2, box.y - _HEIGHT / 2)
    round_box = FancyBboxPatch(corner, _WIDTH, _HEIGHT, "round,pad=0.03,rounding_size=0.12")
    edge = drawing.RESULT if meets else palette.PALE
    round_box.set(facecolor="white", edgecolor=edge, linewidth=2.4 if meets else 1.2)
    axes.add_patch(round_box)

    name, words = box.words.split("\n")
    centred: dict[str, Any] = {"ha": "center", "va": "center"}
    axes.text(box.x, box.y + 0.1, name, fontsize=11.5, fontweight="bold", **centred)
    axes.text(box.x, box.y - 0.14, words, fontsize=9.5, color="0.35", **centred)


def _draw_edge(axes: Axes, source: _Box, target: _Box, color: str, words: str) -> None:
    """One derivative, against the direction in which the quantities depend on each other."""
    gap = _WIDTH / 2 + 0.07
    start = np.array([source.x + gap, source.y])
    end = np.array([target.x - gap, target.y + 0.12 * np.sign(source.y - target.y)])
    drawing.draw_arrow(axes, start, end - start, color, width=2.2)

    middle = (start + end) / 2
    side = 0.2 if source.y >= target.y else -0.3
    axes.text(middle[0] + 0.05, middle[1] + side, words, ha="center", fontsize=10, color=color)
