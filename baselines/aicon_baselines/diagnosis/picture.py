"""The picture of a diagnosis: where the robot was, and its costs, conflicts and actions in time."""

import textwrap
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from aicon_baselines.diagnosis.diagnose import Diagnosis
from aicon_baselines.diagnosis.history import History
from aicon_baselines.evaluation.recording import BoolArray, FloatArray, true_intervals
from aicon_baselines.figures.rendering import save_picture
from aicon_baselines.figures.timeline import SHADE, simplify
from aicon_baselines.palette import CURVES, OBJECT, PALE, ROBOT
from aicon_baselines.worlds import Shape
from aicon_baselines.worlds.paper import Paper

_WIDTH = 165
"""Letters in a line of the text."""


def draw_diagnosis(
    history: History,
    found: Diagnosis,
    path: Path,
    *,
    title: str = "",
    places: FloatArray | None = None,
    around: Mapping[str, Shape] = MappingProxyType({}),
    flipped: bool = False,
) -> None:
    """Save the picture of a diagnosis, with its words below.

    Args:
        history: The episode of n steps.
        found: What was found in it.
        path: Where to save the picture, as png.
        title: Of the picture.
        places: Where the robot was, (n, 2 or more), in the world's frame; by default the two
            directions in which its estimates changed most.
        around: What lay around it, in the same frame.
        flipped: Whether y of that frame points down.
    """
    text = _wrapped(str(found))
    height = 6.1 + 0.19 * text.count("\n")
    figure = Figure(figsize=(12, height), dpi=110, layout="constrained")
    figure.suptitle(title, x=0.012, ha="left", fontsize=12, fontweight="bold")
    figure.supxlabel(text, x=0.012, ha="left", fontsize=9.5, color="0.15", linespacing=1.35)
    grid = figure.add_gridspec(3, 2, width_ratios=(1, 1.5))

    # Left: where it was.
    world = figure.add_subplot(grid[:, 0])
    Paper(world).draw(around)
    if flipped:
        world.invert_yaxis()
    _draw_places(world, history, found, places)

    # Right: costs, conflicts and actions over the same time.
    timelines = [figure.add_subplot(grid[row, 1]) for row in range(3)]
    _draw_costs(timelines[0], history)
    _draw_cosines(timelines[1], history)
    _draw_actions(timelines[2], history)
    for axes in timelines:
        _finish_timeline(axes, history, found)
    for axes in timelines[:-1]:
        axes.tick_params(labelbottom=False)
    timelines[-1].set_xlabel("time, s")
    save_picture(figure, path)


def _draw_places(axes: Axes, history: History, found: Diagnosis, places: FloatArray | None) -> None:
    """Where it was, before the behaviour and during it."""
    if places is None:
        way, labels = _projected(history.state), ("estimates, first component", "second")
    else:
        way, labels = places[:, :2], ("x", "y")
    since = min(round(found.behaviour.begin / history.dt), len(way) - 1)

    axes.plot(*way[: since + 1].T, color=OBJECT, linewidth=1.4, label="before")
    axes.plot(*way[since:].T, color=ROBOT, linewidth=1.1, label="in the end")
    axes.plot(*way[0], "o", color=PALE, markersize=7, markeredgecolor="white", label="start")
    axes.plot(*way[-1], "s", color=ROBOT, markersize=8, markeredgecolor="white", label="end")

    axes.set_xlabel(labels[0])
    axes.set_ylabel(labels[1])
    if places is not None:
        axes.set_aspect("equal", adjustable="datalim")
    axes.legend(
        frameon=False,
        fontsize=9,
        ncols=3,
        loc="lower center",
        bbox_to_anchor=(0.5, 1.0),
        columnspacing=1.0,
        handlelength=1.2,
    )
    simplify(axes)


def _draw_costs(axes: Axes, history: History) -> None:
    for color, (name, cost) in zip(CURVES, history.costs.items(), strict=False):
        axes.plot(history.times, cost, color=color, linewidth=1.3, label=name)
    axes.set_ylabel("cost")


def _draw_cosines(axes: Axes, history: History) -> None:
    """How much the dominant gradient is opposed, and where a quantity explores."""
    explores = np.zeros(history.steps, dtype=np.bool_)
    for color, (name, curve) in zip(CURVES, history.meetings.items(), strict=False):
        axes.plot(history.times, curve.cosine, color=color, linewidth=0.9, label=f"at {name}")
        explores |= curve.exploring

    _shade(axes, history, explores)
    axes.set_ylim(-1.08, 1.08)
    axes.set_ylabel("cosine to the opponent")


def _draw_actions(axes: Axes, history: History) -> None:
    """The largest share of its limit that each actuator used."""
    escapes = np.zeros(history.steps, dtype=np.bool_)
    for color, (name, curve) in zip(CURVES, history.actuators.items(), strict=False):
        axes.plot(history.times, curve.share.max(axis=1), color=color, linewidth=0.9, label=name)
        escapes |= curve.escaping

    _shade(axes, history, escapes)
    axes.set_ylim(-0.04, 1.08)
    axes.set_ylabel("share of the limit")


def _shade(axes: Axes, history: History, flags: BoolArray) -> None:
    for begin, end in true_intervals(flags):
        axes.axvspan(history.dt * begin, history.dt * end, **SHADE)


def _finish_timeline(axes: Axes, history: History, found: Diagnosis) -> None:
    axes.set_xlim(0, history.times[-1])
    axes.axvline(found.behaviour.begin, color="0.25", linewidth=0.8, linestyle=(0, (2, 2)))
    simplify(axes)

    handles, _ = axes.get_legend_handles_labels()
    if axes.patches:
        handles.append(Patch(**SHADE, label="exploring"))
    if handles:
        axes.legend(handles=handles, frameon=False, fontsize=8.5, loc="upper right", ncols=4)


def _projected(state: FloatArray) -> FloatArray:
    """The state along the two directions in which it changed most, (n, 2)."""
    deviation = state.std(axis=0)
    scaled = (state - state.mean(axis=0)) / np.where(deviation > 0, deviation, 1.0)
    _, _, directions = np.linalg.svd(scaled, full_matrices=False)
    along: FloatArray = scaled @ directions[:2].T
    return along if along.shape[1] == 2 else np.pad(along, ((0, 0), (0, 1)))


def _wrapped(text: str) -> str:
    lines: list[str] = []
    for line in text.splitlines():
        indent = "  " if line.startswith("- ") else ""
        lines += textwrap.wrap(line, _WIDTH, subsequent_indent=indent)
    return "\n".join(lines)
