"""A rollout as a figure: six moments above curves over time, and a film of the whole episode.

Navigation, pushing and the arm are told in the same way; what differs between them is a `Rollout`.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Mapping, Sequence
from math import ceil
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.legend_handler import HandlerTuple

from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.evaluation.recording import Recording, runs_of, track
from aicon_baselines.figures.rendering import (
    Frame,
    is_moving_picture,
    render,
    save_picture,
    save_video,
)
from aicon_baselines.figures.summary import FigureFiles, FigureSummary
from aicon_baselines.figures.timeline import TimeCursor, curve_handles
from aicon_baselines.figures.view import WorldView
from aicon_baselines.palette import ROBOT

LABELS = "abcdef"
"""Labels of the panels, in order of time: three in each of two rows."""

BRIEF = 0.005
"""Share of the episode below which a phase is not shown."""

DURATION = 22.0
"""How long a film lasts at most, s; of a longer one some steps are left out."""

_TITLE = 0.3  # inches
_MARK: dict[str, Any] = {"color": "0.25", "linewidth": 0.8, "linestyle": (0, (2, 2))}


class Panel(NamedTuple):
    """One moment of an episode: its label, its step and what happens there, in plain words."""

    label: str
    step: int
    title: str


class Rollout(ABC):
    """What the figure of a task tells of an episode.

    Args:
        recording: The episode.

    Attributes:
        recording: The episode.
        name: Of the figure's files.
        aspect: Width of the world's picture over its height.
        curves: The diagrams over time, from the top, with their heights in the picture, inches.
        caption: How to read the picture, in two lines.
        legend_rows: Rows of the curves' legend.
        first_step: The first step that can be shown.
        arrival: What a success is called.
    """

    recording: Recording
    name: ClassVar[str]
    aspect: ClassVar[float]
    curves: ClassVar[Mapping[str, float]]
    caption: ClassVar[str] = ""
    legend_rows: ClassVar[int] = 1
    first_step: ClassVar[int] = 0
    arrival: ClassVar[str] = "Arrival at the target"

    def __init__(self, recording: Recording) -> None:
        self.recording = recording

    def phase(self, step: int) -> str:
        """What happens at a step, in plain words; at the last one how the episode ends."""
        if step < len(self.recording.memories) - 1:
            return self.doing(step)

        endings = {"arrival": self.arrival, "time limit": "Out of time"}
        ending = self.recording.ending
        return endings.get(ending, ending.capitalize())

    @abstractmethod
    def doing(self, step: int) -> str:
        """What is done at a step before the last one, in plain words."""

    @abstractmethod
    def make_view(self, axes: Axes, coarseness: float = 1.0) -> WorldView:
        """The world, drawn so many times as coarsely as it could be."""

    @abstractmethod
    def draw_curves(self, *diagrams: Axes) -> None:
        """Draw the curves, labelled, into the diagrams of `curves`."""

    def marks(self) -> dict[str, Any]:
        """What the pictures of the world consist of: a handle of the legend by its label."""
        return {}

    def numbers(self) -> dict[str, Any]:
        """The numbers of the figure besides those that every episode has."""
        return {}


def save_rollout(rollout: Rollout, files: FigureFiles) -> FigureSummary:
    """Save picture, film and numbers, and say what they show.

    Raises:
        ComparisonError: If the episode is too short for six panels, or imageio is not installed
            and the film is an mp4.
    """
    panels = choose_panels(rollout)
    draw_picture(rollout, panels, files.picture)
    if files.film is not None:
        draw_film(rollout, files.film)

    numbers = summarize(rollout, panels)
    return files.summary(f"{numbers['ending']} after {numbers['duration_s']} s", numbers)


def choose_panels(rollout: Rollout) -> list[Panel]:
    """The moments of a rollout: the middle of the longest run of each phase, and the end.

    Of more than five phases those with the longest runs are shown; where there are fewer, the
    longest runs are shown more than once.

    Raises:
        ComparisonError: If the episode is too short for six panels.
    """
    last = len(rollout.recording.memories) - 1
    if last < len(LABELS):
        raise ComparisonError(
            f"the episode has {rollout.recording.steps} steps; six panels need 7 or more"
        )

    phases = [rollout.phase(step) for step in range(1, last)]
    longest: dict[str, range] = {}
    for begin, end in runs_of(phases):
        if end - begin > len(longest.get(phases[begin], ())):
            longest[phases[begin]] = range(1 + begin, 1 + end)

    # A phase of a moment is none; the longest run is halved until there are five.
    count = len(LABELS) - 1
    lasting = [run for run in longest.values() if len(run) >= BRIEF * last]
    if sum(map(len, lasting)) < count:
        lasting = [range(1, last)]
    shown = sorted(lasting, key=len)[-count:]
    while len(shown) < count:
        run = max(shown, key=len)
        middle = len(run) // 2
        shown[shown.index(run)] = run[:middle]
        shown.append(run[middle:])

    steps = sorted(run[len(run) // 2] for run in shown)
    panels = zip(LABELS, (*steps, last), strict=True)
    return [Panel(label, step, rollout.phase(step)) for label, step in panels]


def summarize(rollout: Rollout, panels: Sequence[Panel]) -> dict[str, Any]:
    """The numbers of a figure: how the episode ended, and when its moments were."""
    recording, dt = rollout.recording, rollout.recording.time_step

    shown = []
    for panel in panels:
        time = round(panel.step * dt, 3)
        shown.append({"panel": panel.label, "time_s": time, "title": panel.title})

    explorations = []
    for begin, end in recording.explorations:
        explorations.append([round(begin * dt, 3), round(end * dt, 3)])

    return {
        "seed": recording.seed,
        "ending": recording.ending,
        "steps": recording.steps,
        "duration_s": round(recording.steps * dt, 3),
        **rollout.numbers(),
        "panels": shown,
        "explorations_s": explorations,
    }


def draw_picture(rollout: Rollout, panels: Sequence[Panel], path: Path) -> None:
    """Save the picture: six moments above the curves over time."""
    # From the bottom, in inches: caption, curves, their legend, two rows of panels, the legend.
    panel_height = 4.5 / rollout.aspect
    curves_top = 0.95 + sum(rollout.curves.values()) + 0.12 * (len(rollout.curves) - 1)
    panels_bottom = curves_top + 0.34 + 0.22 * rollout.legend_rows
    panels_top = panels_bottom + 2 * panel_height + _TITLE
    height = panels_top + 0.6
    figure = Figure(figsize=(14.0, height), dpi=130)

    # The world at each moment.
    area = {"bottom": panels_bottom / height, "top": panels_top / height}
    gaps = {"hspace": _TITLE / panel_height, "wspace": 0.025}
    cells = figure.add_gridspec(2, 3, left=0.012, right=0.988, **area, **gaps)
    for index, panel in enumerate(track(panels, "picture")):
        view = rollout.make_view(figure.add_subplot(cells[index]))
        view.show(panel.step)
        view.set_title(rf"$\mathbf{{{panel.label}}}$   {panel.title}", size=12)
    _add_legend(figure, rollout.marks())

    # What happens meanwhile.
    area = {"left": 0.065, "right": 0.988, "bottom": 0.95 / height, "top": curves_top / height}
    diagrams = _add_diagrams(figure, list(rollout.curves.values()), **area)
    rollout.draw_curves(*diagrams)
    for axes in diagrams:
        axes.yaxis.set_label_coords(-0.04, 0.5)
    for axes in diagrams[:-1]:
        axes.tick_params(labelbottom=False)
    mark_panels(diagrams, panels, rollout.recording.time_step)
    place = (0.055, (curves_top + 0.17) / height)
    _add_curve_legend(figure, diagrams, place, rollout.legend_rows, size=10)

    figure.text(0.012, 0.1 / height, rollout.caption, fontsize=8.5, color="0.3", linespacing=1.35)
    save_picture(figure, path)


def mark_panels(diagrams: Sequence[Axes], panels: Sequence[Panel], dt: float) -> None:
    """Mark the time of each panel in all diagrams, and write its label above the first one.

    Args:
        diagrams: The axes, from top to bottom.
        panels: The panels.
        dt: Time of a step, s.
    """
    for panel in panels:
        time = panel.step * dt
        for axes in diagrams:
            axes.axvline(time, **_MARK)

        # Just above the axes, whatever their limits are.
        diagrams[0].annotate(
            panel.label,
            (time, 1.0),
            (0, 2),
            ("data", "axes fraction"),
            textcoords="offset points",
            ha="center",
            fontsize=10,
            fontweight="bold",
        )


class RolloutFilm:
    """The world above the curves over time.

    Args:
        rollout: What is shown.
        coarseness: How coarsely the world is drawn.
        dpi: Resolution, dots per inch.
    """

    def __init__(self, rollout: Rollout, coarseness: float, dpi: float) -> None:
        # From the bottom, in inches: curves, their legend, the world, its title.
        curves_top = 0.1 + 0.6 * len(rollout.curves)
        world_bottom = curves_top + 0.2 + 0.18 * rollout.legend_rows
        world_height = 7.76 / rollout.aspect
        height = round(world_bottom + world_height + _TITLE, 1)
        self._figure = Figure(figsize=(8.0, height), dpi=dpi)
        self._rollout = rollout

        place = (0.015, world_bottom / height, 0.97, world_height / height)
        self._view = rollout.make_view(self._figure.add_axes(place), coarseness)

        area = {"left": 0.1, "right": 0.985, "bottom": 0.1 / height, "top": curves_top / height}
        diagrams = _add_diagrams(self._figure, [1.0] * len(rollout.curves), **area)
        rollout.draw_curves(*diagrams)
        # Time passes in the picture above: the axes need no numbers.
        for axes, label in zip(diagrams, rollout.curves, strict=True):
            axes.set(xticks=[], yticks=[], xlabel="")
            axes.set_ylabel(label, fontsize=9, rotation=0, ha="right", va="center")
        corner = (0.09, (curves_top + 0.02) / height)
        _add_curve_legend(self._figure, diagrams, corner, rollout.legend_rows, size=8)
        self._cursor = TimeCursor(diagrams, ROBOT)

    def frames(self, steps: Iterable[int], hold: int = 0) -> Iterator[Frame]:
        """Render the world and the curves at each step, and the last one `hold` times more."""
        for step in steps:
            self._view.show(step)
            self._view.set_title(self._rollout.phase(step), size=11)
            self._cursor.move(self._rollout.recording.times[step])
            frame = render(self._figure)
            yield frame

        for _ in range(hold):
            yield frame


def draw_film(rollout: Rollout, path: Path) -> None:
    """Save the episode as a video, mp4 or webp by the name of the file.

    An mp4 plays in real time where 15 frames a second allow it; moving pictures are slower and
    coarser. The last frame rests for a second.

    Args:
        rollout: What is shown.
        path: Where to save the video.

    Raises:
        ComparisonError: If imageio is not installed and the video is an mp4.
    """
    small = is_moving_picture(path)
    film = RolloutFilm(rollout, coarseness=3.0 if small else 1.5, dpi=60 if small else 100)

    rate = 5 if small else min(15, round(1.0 / rollout.recording.time_step))
    steps = track(film_steps(rollout, rate), "video")
    save_video(film.frames(steps, hold=rate), path, rate)


def film_steps(rollout: Rollout, rate: int) -> range:
    """The steps that a film with so many frames a second shows."""
    count = len(rollout.recording.memories)
    return range(rollout.first_step, count, ceil(count / (DURATION * rate)))


def _add_diagrams(figure: Figure, heights: Sequence[float], **area: float) -> list[Axes]:
    """Diagrams below each other within an area, in shares of the figure."""
    gap = 0.14 if len(heights) > 1 else 0.0
    cells = figure.add_gridspec(len(heights), 1, height_ratios=heights, hspace=gap, **area)
    return [figure.add_subplot(cells[row]) for row in range(len(heights))]


def _add_curve_legend(
    figure: Figure, diagrams: Sequence[Axes], corner: tuple[float, float], rows: int, size: float
) -> None:
    """Explain the curves just above them, from a lower left corner, in shares of the figure."""
    handles = curve_handles(diagrams)
    figure.legend(
        handles=handles,
        loc="lower left",
        bbox_to_anchor=corner,
        ncols=ceil(len(handles) / rows),
        frameon=False,
        fontsize=size,
        columnspacing=1.6,
        borderaxespad=0.0,
    )


def _add_legend(figure: Figure, marks: Mapping[str, Any]) -> None:
    """Explain above all panels, in one row, what they show; a tuple of handles is drawn as one."""
    if not marks:
        return
    figure.legend(
        handles=list(marks.values()),
        labels=list(marks),
        handler_map={tuple: HandlerTuple(ndivide=1)},
        loc="upper center",
        bbox_to_anchor=(0.5, 1.004),
        ncols=len(marks),
        frameon=False,
        fontsize=10,
    )
