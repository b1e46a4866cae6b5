"""The pushing figure: the gradients at the pusher, above the error and their strengths."""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import LogLocator, NullLocator

from aicon_baselines import palette
from aicon_baselines.figures.pusht.recording import PushRecording, record
from aicon_baselines.figures.pusht.view import ASPECT, PushView
from aicon_baselines.figures.rollout import Rollout, save_rollout
from aicon_baselines.figures.summary import FigureFiles, FigureSummary
from aicon_baselines.figures.timeline import gaps_at_zero, prepare_timeline
from aicon_baselines.figures.view import dot
from aicon_baselines.worlds.surroundings import GOAL_TINT
from aicon_torch import make_policy

DEFAULT_SEED = 1043
"""Of 1000 to 1059 a short episode in which everything happens that the figure tells."""


class PushRollout(Rollout):
    """An episode of pushing."""

    name = "pusht_rollout"
    aspect = ASPECT
    curves = {"pose error": 0.87, "gradients": 0.87}
    caption = (
        "Coloured arrows: descent directions of the strongest gradients that meet at the pusher, "
        "one for each contact; the wider, the stronger. Dots: their contacts, the larger, the "
        "likelier.\nLarge arrow: the motion commanded for the next 0.1 s. Purple ground: it "
        "explores. One episode of aicon/PushT-v0."
    )
    arrival = "Arrival in the goal pose"
    recording: PushRecording

    def doing(self, step: int) -> str:
        """What the policy does."""
        recording = self.recording
        if recording.exploring[step]:
            at_corner = recording.at_corners[step]
            return f"Conflict {'at a corner' if at_corner else 'at a side'}: exploring"

        strongest = recording.strengths[step].argmax()
        if not recording.useful[step, strongest]:
            return "Withdrawing from a detrimental contact"
        if recording.touched[step]:
            return "Pushing a useful contact"
        return "Going to a useful contact"

    def make_view(self, axes: Axes, coarseness: float = 1.0) -> PushView:
        """The table; it is always drawn as finely as it can be."""
        return PushView(axes, self.recording)

    def draw_curves(self, *diagrams: Axes) -> None:
        """The pose error, and the strongest gradients of useful and of detrimental contacts."""
        recording, (cost, gradients) = self.recording, diagrams
        for axes in diagrams:
            prepare_timeline(axes, recording)

        cost.plot(recording.times, recording.costs, color=palette.OBSTACLE, linewidth=1.8)
        cost.set(ylim=(0, 1.08 * recording.costs.max()))
        cost.set_ylabel("pose error\ng (px)")

        kinds = (("useful", True, palette.TOWARDS), ("detrimental", False, palette.AWAY))
        for kind, useful, color in kinds:
            strengths = gaps_at_zero(recording.strongest(useful=useful))
            label = f"strongest gradient of a {kind} contact"
            gradients.plot(recording.times, strengths, color=color, linewidth=1.6, label=label)

        # The likelihood of a far contact is tiny: what is below the limit acts on nothing.
        highest = 1.6 * recording.strengths.max()
        gradients.set(yscale="log", ylim=(3e-5, highest), xlabel="time (s)")
        gradients.set_ylabel("gradient\nstrength")
        gradients.yaxis.set_major_locator(LogLocator(numticks=5))
        gradients.yaxis.set_minor_locator(NullLocator())

    def marks(self) -> dict[str, Any]:
        """Pusher, object and goal, contacts and their gradients."""
        trail = Line2D([], [], color=to_rgba(palette.ROBOT, 0.6), linewidth=2.2)
        goal_area = to_rgba(palette.GOAL, GOAL_TINT)
        motion = Patch(facecolor=palette.MOTION, edgecolor=palette.INK, linewidth=1.5)

        return {
            "pusher and its way": (trail, dot(palette.ROBOT, 10)),
            "object": Patch(facecolor=palette.OBJECT, edgecolor=palette.OUTLINE),
            "goal pose": Patch(facecolor=goal_area, edgecolor=palette.GOAL, linewidth=2),
            "useful contact, its gradient": _contact(palette.TOWARDS),
            "detrimental contact, its gradient": _contact(palette.AWAY),
            "commanded motion": motion,
        }

    def numbers(self) -> dict[str, Any]:
        """The way of the pusher, and the error at the start and in the end."""
        pieces = np.linalg.norm(np.diff(self.recording.pushers, axis=0), axis=1)
        start, end = self.recording.costs[[0, -1]].tolist()
        return {
            "path_length_px": round(float(pieces.sum()), 1),
            "pose_error_px": {"start": round(start, 2), "end": round(end, 2)},
        }


def _contact(color: str) -> tuple[Line2D, Line2D]:
    """A contact and its gradient, in a legend."""
    return Line2D([], [], color=color, linewidth=2.5), dot(color, 8)


def make_figure(out: Path, seed: int = DEFAULT_SEED, video: str = "mp4") -> FigureSummary:
    """Roll the policy out and save `pusht_rollout.png`, `.json` and, unless "none", the video.

    The arguments and errors are those of :func:`aicon_baselines.figures.nav2d.make_figure`.
    """
    files = FigureFiles(out, PushRollout.name, video)
    recording = record(make_policy("pusht").compile(), seed)
    return save_rollout(PushRollout(recording), files)
