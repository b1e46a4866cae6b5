"""The navigation figure: the potential as it changes, above the strengths of the paths."""

from pathlib import Path
from typing import Any

from matplotlib.axes import Axes
from matplotlib.colors import to_rgba
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import LogLocator, NullLocator, StrMethodFormatter

from aicon_baselines import palette
from aicon_baselines.figures.nav2d.recording import NavigationRecording, record
from aicon_baselines.figures.nav2d.view import ASPECT, HEIGHT, TINT, NavigationView
from aicon_baselines.figures.rollout import Rollout, save_rollout
from aicon_baselines.figures.summary import FigureFiles, FigureSummary
from aicon_baselines.figures.timeline import prepare_timeline
from aicon_baselines.figures.view import dot, target_mark
from aicon_envs.nav2d import shortest_path_length
from aicon_torch import make_policy

_PATHS = {
    "p1": ("Approaching the target", "p₁ nearer to the target", palette.TOWARDS),
    "p2": ("Triangulating", "p₂ less uncertainty", palette.CERTAINTY),
    "p3": ("Keeping clear", "p₃ clear of obstacles", palette.AWAY),
}
"""What the agent does where a path is the strongest, what the path is for, and its colour."""


class NavigationRollout(Rollout):
    """An episode of navigation.

    Args:
        recording: The episode.
        spacing: Distance of the sampled positions in the picture, m.
    """

    name = "nav2d_rollout"
    aspect = ASPECT
    curves = {"strengths": 1.18}
    caption = (
        "Arrows: direction of the resolved descent, sampled densely with the agent's memory of "
        "that moment; the clearance at other positions is the true one. Background: the potential "
        "whose slope fits\nthese samples best (least squares). The agent itself computes only the "
        "gradient at its own position. One rollout of aicon/Nav2D-v0 with its noise."
    )
    first_step = 1  # before it the agent remembers nothing
    recording: NavigationRecording

    def __init__(self, recording: NavigationRecording, spacing: float = 0.04) -> None:
        super().__init__(recording)
        self._spacing = spacing

    def doing(self, step: int) -> str:
        """What the agent does."""
        if self.recording.exploring[step]:
            return "Conflict: exploring along the wall"

        strengths = self.recording.strengths
        strongest = max(strengths, key=lambda name: strengths[name][step])
        doing, _, _ = _PATHS[strongest]
        return doing

    def make_view(self, axes: Axes, coarseness: float = 1.0) -> NavigationView:
        """The world, on a grid that is so much coarser than in the picture."""
        return NavigationView(axes, self.recording, coarseness * self._spacing)

    def draw_curves(self, *diagrams: Axes) -> None:
        """The strength of each path and the uncertainty."""
        (axes,) = diagrams
        recording = self.recording
        prepare_timeline(axes, recording)

        for name, strengths in recording.strengths.items():
            _, label, color = _PATHS[name]
            axes.plot(recording.times, strengths, color=color, linewidth=1.6, label=label)
        axes.plot(
            recording.times,
            recording.uncertainty,
            color=palette.BELIEF,
            linewidth=1.8,
            linestyle=(0, (4, 1.5)),
            label="uncertainty tr Σ",
        )

        # Both units differ and both fall by decades: one logarithmic axis, with plain numbers.
        axes.set(yscale="log", ylim=(2e-3, 60), xlabel="time (s)")
        axes.set_ylabel("path strength,\nuncertainty (m²)")
        axes.yaxis.set_major_locator(LogLocator(numticks=6))
        axes.yaxis.set_minor_locator(NullLocator())
        axes.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))

    def marks(self) -> dict[str, Any]:
        """The agent, what it believes, and its potential."""
        trail = Line2D([], [], color=palette.ROBOT, linewidth=2.2)
        spread = dot(to_rgba(palette.BELIEF, 0.2), 13, edge=palette.BELIEF)
        tint = to_rgba(palette.EXPLORING, TINT)

        return {
            "agent and its way": (trail, dot(palette.ROBOT, 8)),
            "target": target_mark(),
            "believed target (2σ)": (spread, dot(palette.BELIEF, 5.5)),
            "obstacle": Patch(color=palette.OBSTACLE),
            "where it would explore": Patch(facecolor=tint, edgecolor=palette.EXPLORING),
            "potential high": Patch(facecolor=HEIGHT(0.85)),
            "potential low": Patch(facecolor=HEIGHT(0.05), edgecolor="0.7"),
        }

    def numbers(self) -> dict[str, Any]:
        """The map, the lengths of the ways, and how the uncertainty falls."""
        recording, world = self.recording, self.recording.world
        shortest = shortest_path_length(
            world.obstacles, world.start, world.target, recording.radius
        )

        uncertainty: dict[str, float] = {}
        for seconds in (0, 1, 5):
            step = round(seconds / recording.time_step)
            if step < recording.steps:
                uncertainty[f"{seconds} s"] = float(recording.uncertainty[step])

        return {
            "map": world.name,
            "path_length_m": round(float(recording.travelled[-1]), 3),
            "shortest_path_m": round(shortest, 3),
            "trace_sigma_m2": uncertainty,
        }


def make_figure(
    out: Path,
    seed: int = 1006,
    video: str = "mp4",
    *,
    map_name: str = "u_trap_2",
    spacing: float = 0.04,
) -> FigureSummary:
    """Roll the policy out and save `nav2d_rollout.png`, `.json` and, unless "none", the video.

    Args:
        out: Folder, made if it does not exist.
        seed: Seed of the map and of the noise.
        video: One of `aicon_baselines.figures.VIDEO_FORMATS`.
        map_name: Class of the map.
        spacing: Distance of the sampled positions in the picture, m; the video's are 1.5 times as
            far apart, and those of a moving picture 3 times.

    Raises:
        ComparisonError: If the class of maps or the format of the video is unknown, the rollout is
            too short for six panels, or imageio is not installed and the video is an mp4.
    """
    files = FigureFiles(out, NavigationRollout.name, video)
    recording = record(make_policy("nav2d").compile(), map_name, seed)
    return save_rollout(NavigationRollout(recording, spacing), files)
