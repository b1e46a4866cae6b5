"""The pose error and the strengths of the gradients over time."""

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullLocator

from aicon_baselines.figures.pusht.recording import PushRecording
from aicon_baselines.figures.timeline import gaps_at_zero, prepare_timeline, simplify
from aicon_baselines.palette import AWAY, OBSTACLE, TOWARDS

Rectangle = tuple[float, float, float, float]


def add_timelines(
    figure: Figure, recording: PushRecording, upper: Rectangle, lower: Rectangle
) -> tuple[Axes, Axes]:
    """Add the pose error and, below it, the strengths of the gradients.

    Args:
        figure: Where to draw.
        recording: The episode.
        upper: Left, bottom, width and height of the pose error, in shares of the figure.
        lower: The same of the strengths.
    """
    cost, strengths = figure.add_axes(upper), figure.add_axes(lower)
    _draw_cost(cost, recording)
    _draw_strengths(strengths, recording)
    return cost, strengths


def _draw_cost(axes: Axes, recording: PushRecording) -> None:
    """Draw the pose error over time."""
    prepare_timeline(axes, recording)
    axes.plot(recording.times, recording.costs, color=OBSTACLE, linewidth=1.8)

    axes.set(ylim=(0, 1.08 * recording.costs.max()))
    axes.set_ylabel("pose error\ng (px)")
    simplify(axes)


def _draw_strengths(axes: Axes, recording: PushRecording) -> None:
    """Draw the strongest gradient of a useful and of a detrimental contact over time."""
    prepare_timeline(axes, recording)
    useful = gaps_at_zero(recording.strongest(useful=True))
    detrimental = gaps_at_zero(recording.strongest(useful=False))

    times = recording.times
    label = "strongest gradient of a useful contact"
    axes.plot(times, useful, color=TOWARDS, linewidth=1.6, label=label)
    label = "strongest gradient of a detrimental contact"
    axes.plot(times, detrimental, color=AWAY, linewidth=1.6, label=label)

    # The likelihood of a far contact is tiny: what is below the limit acts on nothing.
    axes.set(yscale="log", ylim=(3e-5, 1.6 * recording.strengths.max()), xlabel="time (s)")
    axes.set_ylabel("gradient\nstrength")
    axes.yaxis.set_major_locator(LogLocator(numticks=5))
    axes.yaxis.set_minor_locator(NullLocator())
    simplify(axes)
