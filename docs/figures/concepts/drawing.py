"""How the pictures of concepts are drawn: the same colours and marks in all six."""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from aicon_baselines.evaluation.recording import FloatArray, to_array
from aicon_baselines.figures.rendering import save_picture
from aicon_baselines.figures.view import target_mark
from aicon_baselines.palette import EXPLORING, INK, OBJECT, OBSTACLE, ROBOT, TARGET
from aicon_torch.inspection import QuantityTrace
from concepts.world import Wall

REACH, AVOID, RESULT, EXPLORES = TARGET, OBSTACLE, ROBOT, EXPLORING
"""Colours: what the goals "reach" and "avoid" want, what comes of it, and exploration."""

PATHS = {"reach": REACH, "avoid": AVOID}


def new_figure(
    columns: int, *, height: float = 3.4, widths: tuple[float, ...] = (), below: float = 0.1
) -> list[Axes]:
    """Panels side by side, of a figure that is 11 inches wide.

    Args:
        columns: Number of panels.
        height: Of the figure, inches.
        widths: Of the panels, in relation to each other.
        below: Room for the labels of an axis, inches.
    """
    figure = Figure(figsize=(11, height), dpi=100)
    grid = figure.add_gridspec(
        1,
        columns,
        width_ratios=widths or (1,) * columns,
        left=0.02,
        right=0.98,
        top=1 - 0.42 / height,
        bottom=below / height,
        wspace=0.16 if below > 0.1 else 0.08,
    )
    return [figure.add_subplot(grid[column]) for column in range(columns)]


def as_world(
    axes: Axes,
    wall: Wall | None,
    target: tuple[float, float],
    *,
    x: tuple[float, float],
    y: tuple[float, float],
    title: str,
) -> None:
    """Let axes show a part of the world, without ticks: its wall and its target."""
    axes.set(xlim=x, ylim=y, aspect="equal", xticks=[], yticks=[])
    axes.set_title(title, fontsize=11, loc="left", color=INK)
    axes.spines[:].set_color(OBJECT)

    axes.add_line(target_mark(*target))
    if wall is not None:
        ends = np.array([wall.start, wall.end])
        axes.plot(*ends.T, color=OBSTACLE, linewidth=9, solid_capstyle="round", zorder=3)


def draw_robot(axes: Axes, place: FloatArray) -> None:
    """The robot at a place (2,)."""
    axes.plot(*place, "o", color=ROBOT, markersize=13, markeredgecolor="white", zorder=6)


def wants_of(meeting: QuantityTrace) -> dict[str, FloatArray]:
    """What each goal wants where two gradients meet: the negative of its gradient, (2,)."""
    descents = -to_array(meeting.gradients)
    return {goal: descent for (goal,), descent in zip(meeting.goals, descents, strict=True)}


def draw_wants(
    axes: Axes, place: FloatArray, meeting: QuantityTrace, *, length: float, width: float = 3.0
) -> None:
    """What each goal wants at a place (2,), by arrows so long at strength 1, m."""
    for goal, descent in wants_of(meeting).items():
        draw_arrow(axes, place, length * descent, PATHS[goal], width=width)


def draw_arrow(
    axes: Axes, start: FloatArray, vector: FloatArray, color: str, width: float = 3.0, **looks: Any
) -> None:
    """An arrow from a point (2,) along a vector (2,), if it has a length."""
    if np.linalg.norm(vector) < 1e-6:
        return
    ends: dict[str, Any] = {"xy": tuple(start + vector), "xytext": tuple(start)}
    shape = {"arrowstyle": "-|>", "shrinkA": 0, "shrinkB": 0, "joinstyle": "miter"}
    size = {"linewidth": width, "mutation_scale": 6 + 3 * width}
    axes.annotate("", **ends, arrowprops={"color": color, **shape, **size, **looks}, zorder=5)


def note(axes: Axes, text: str, place: tuple[float, float] = (0.03, 0.05)) -> None:
    """Words in a corner, in shares of the axes."""
    axes.text(
        *place,
        text,
        transform=axes.transAxes,
        fontsize=9.5,
        color="0.25",
        linespacing=1.35,
        va="bottom" if place[1] < 0.5 else "top",
    )


def save(axes: list[Axes], path: Path) -> None:
    """Save the figure that these panels belong to."""
    figure = axes[0].figure
    assert isinstance(figure, Figure)
    save_picture(figure, path)
