"""The world at one moment: object, goal, pusher, contacts, and the gradients at the pusher."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgba
from matplotlib.patches import Rectangle

from aicon_baselines import palette
from aicon_baselines.evaluation.recording import FloatArray
from aicon_baselines.figures.pusht.recording import PushRecording
from aicon_baselines.figures.view import WorldView, rectangle_around
from aicon_baselines.worlds import Shape, arrow, disc, pushing
from aicon_baselines.worlds.paper import Paper
from aicon_envs.pusht.simulation import PUSHER_RADIUS, WALL_HIGH, WALL_LOW

ASPECT = 1.5
"""Width of the picture over its height."""

_TINT = 0.08  # opacity of the ground that says "exploring"
_MARGIN = 10.0  # px around what is shown
_ARROWS = 4  # gradients to show at most
_WEAKEST = 0.06  # and as strong as this share of the strongest
_SHORTEST = 16.0  # px that the arrow of the commanded motion is long at least
_BADGE = {"boxstyle": "round,pad=0.32,rounding_size=0.7", "edgecolor": "none"}
_FADING = 12  # steps until the trajectory is pale


class PushView(WorldView):
    """The world at one moment.

    Args:
        axes: Where to draw.
        recording: The episode.
    """

    def __init__(self, axes: Axes, recording: PushRecording) -> None:
        super().__init__(axes)
        self._recording = recording

        # The walls are what is left of the axes; y points down.
        (left, top), (right, bottom) = _limits(recording)
        axes.set(xlim=(left, right), ylim=(bottom, top), facecolor=palette.WALL)
        size = WALL_HIGH - WALL_LOW
        axes.add_patch(Rectangle((WALL_LOW, WALL_LOW), size, size, facecolor="white", zorder=0))

        # Where it explores, the floor says so.
        tint = to_rgba(palette.EXPLORING, _TINT)
        self._tint = Rectangle((WALL_LOW, WALL_LOW), size, size, facecolor=tint, zorder=0)
        axes.add_patch(self._tint)
        self._paper = Paper(axes)
        self._trail = LineCollection([], linewidths=2.2, joinstyle="round", zorder=3)
        axes.add_collection(self._trail)
        looks: dict[str, Any] = {"transform": axes.transAxes, "fontsize": 10, "zorder": 12}
        self._cost = axes.text(0.02, 0.04, "", color="0.35", **looks)
        looks |= {"color": "white", "va": "top", "fontweight": "bold"}
        self._badge = axes.text(0.02, 0.962, "", **looks)

    def show(self, step: int) -> None:
        """Bring the picture, and the time above it, to a moment."""
        recording = self._recording
        ended = step == recording.steps
        exploring = bool(recording.exploring[step]) and not ended
        self._tint.set_visible(exploring)
        self.set_time(recording.times[step])
        self._cost.set_text(f"g = {recording.costs[step]:.0f} px")

        # Where the pusher has been so far, the paler the longer ago.
        ages = np.arange(step)[::-1]
        opacities = 0.2 + 0.6 * np.clip(1 - ages / _FADING, 0, 1)
        self._trail.set_segments(list(recording.trajectory[:step]))
        self._trail.set_color([to_rgba(palette.ROBOT, opacity) for opacity in opacities])

        # What is there, and what the policy is about to do.
        shapes = pushing(recording.outline, recording.poses[step], recording.goal)
        shapes["pusher"] = disc(recording.pushers[step], PUSHER_RADIUS, 8, palette.ROBOT)
        if not ended:
            if recording.motions[step].any():
                shapes["motion"] = self._motion(step)
            shapes |= self._gradients(step)
        self._paper.clear()
        self._paper.draw(shapes)

        color = palette.EXPLORING if exploring else palette.BADGE
        self._badge.set(text="exploring" if exploring else "descending", visible=not ended)
        self._badge.set_bbox({**_BADGE, "facecolor": color})

    def _motion(self, moment: int) -> Shape:
        """The displacement that is commanded for the next step, as long as it is in the world."""
        motion = self._recording.motions[moment]
        length = float(np.linalg.norm(motion))
        shown = motion / max(length, 1e-9) * max(length, _SHORTEST)
        return self._arrow(moment, shown, 15.0, 7, palette.MOTION, edge=palette.INK, width=1.5)

    def _gradients(self, moment: int) -> dict[str, Shape]:
        """The strongest gradients as arrows downhill; their contacts, the larger the likelier."""
        recording = self._recording
        strengths = recording.strengths[moment]
        shapes: dict[str, Shape] = {}

        for rank, side in enumerate(np.argsort(-strengths)[:_ARROWS]):
            share = float(strengths[side] / max(strengths.max(), 1e-12))
            if share < _WEAKEST:
                break
            color = palette.TOWARDS if recording.useful[moment, side] else palette.AWAY

            # Length and width grow with the strength.
            direction = recording.descents[moment, side] / strengths[side]
            along, thickness = (18.0 + 38.0 * share**0.5) * direction, 1.4 + 5.2 * share
            looks: dict[str, Any] = {"edge": palette.WHITE, "width": 0.8}
            gradient = self._arrow(moment, along, thickness, 9 - rank / 10, color, **looks)

            # At a corner two contacts coincide: the smaller dot is on top.
            radius = 2.5 + 6.0 * float(recording.likelihoods[moment, side])
            contact = disc(recording.contacts[moment, side], radius, 10 - radius / 100, color)
            shapes |= {f"gradient.{rank}": gradient, f"contact.{rank}": contact}
        return shapes

    def _arrow(
        self,
        moment: int,
        along: FloatArray,
        size: float,
        layer: float,
        color: str,
        **edge: Any,
    ) -> Shape:
        """An arrow from the edge of the pusher along a vector (2,), px."""
        tail = self._recording.pushers[moment] + PUSHER_RADIUS * along / np.linalg.norm(along)
        return arrow(tail, along, size, 1.7 * size + 5.5, layer, color, **edge)


def _limits(recording: PushRecording) -> tuple[FloatArray, FloatArray]:
    """The corners of the smallest rectangle of a view's aspect around all that is shown, px."""
    points = [
        pushing(recording.outline, recording.poses[0], recording.goal)["goal"].points,
        recording.pushers - PUSHER_RADIUS,
        recording.pushers + PUSHER_RADIUS,
    ]
    for moment in range(recording.steps + 1):
        points.append(recording.corners(moment))

    return rectangle_around(np.concatenate(points), _MARGIN, ASPECT)
