"""The world at one moment: object, goal, pusher, contacts, and the gradients at the pusher."""

from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgba
from matplotlib.patches import Circle, FancyArrow, Rectangle

from aicon_baselines import palette
from aicon_baselines.evaluation.recording import FloatArray
from aicon_baselines.figures.pusht.recording import PushRecording
from aicon_baselines.figures.view import WorldView, rectangle_around
from aicon_baselines.worlds import disc, pushing
from aicon_baselines.worlds.paper import Paper
from aicon_envs.pusht.simulation import PUSHER_RADIUS, WALL_HIGH, WALL_LOW

ASPECT = 1.5
"""Width of the picture over its height."""

_TINT = 0.08  # opacity of the ground that says "exploring"
_MARGIN = 10.0  # px around what is shown
_ARROWS = 4  # gradients to show at most
_WEAKEST = 0.06  # and as strong as this share of the strongest
_SHORTEST = 16.0  # px that the arrow of the commanded motion is long at least
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
        self._artists: list[Artist] = []  # of the moment that is shown

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

    def show(self, step: int) -> None:
        """Bring the picture, and the time above it, to a moment."""
        for artist in self._artists:
            artist.remove()
        self._artists = []

        recording = self._recording
        ended = step == recording.steps
        exploring = bool(recording.exploring[step]) and not ended
        self._tint.set_visible(exploring)
        self.set_time(recording.times[step])

        # What is there.
        pusher = disc(recording.pushers[step], PUSHER_RADIUS, 8, palette.ROBOT)
        things = pushing(recording.outline, recording.poses[step], recording.goal)
        self._paper.draw({**things, "pusher": pusher})
        self._add_trajectory(step)
        cost = f"g = {recording.costs[step]:.0f} px"
        self._add_text((0.02, 0.04), cost, color="0.35", va="bottom")

        # What the policy is about to do.
        if not ended:
            self._add_motion(step)
            self._add_gradients(step)
            self._add_badge(exploring)

    def _add(self, artist: Any, zorder: float) -> None:
        """Add what the next moment removes."""
        artist.set_zorder(zorder)
        self._artists.append(self.axes.add_artist(artist))

    def _add_trajectory(self, moment: int) -> None:
        """Where the pusher has been so far, the paler the longer ago."""
        ages = np.arange(moment)[::-1]
        opacities = 0.2 + 0.6 * np.clip(1 - ages / _FADING, 0, 1)
        colors = [to_rgba(palette.ROBOT, opacity) for opacity in opacities]

        pieces = list(self._recording.trajectory[:moment])
        lines = LineCollection(pieces, colors=colors, linewidths=2.2, joinstyle="round")
        self._add(lines, zorder=3)

    def _add_motion(self, moment: int) -> None:
        """The displacement that is commanded for the next step, as long as it is in the world."""
        motion = self._recording.motions[moment]
        length = float(np.linalg.norm(motion))
        shown = motion / max(length, 1e-9) * max(length, _SHORTEST)

        looks = {"facecolor": palette.MOTION, "edgecolor": palette.INK, "linewidth": 1.5}
        self._add_arrow(moment, shown, width=15.0, zorder=7, looks=looks)

    def _add_gradients(self, moment: int) -> None:
        """The strongest gradients as arrows downhill; their contacts, the larger the likelier."""
        strengths = self._recording.strengths[moment]
        strongest_first = np.argsort(-strengths)

        for rank, side in enumerate(strongest_first[:_ARROWS]):
            share = float(strengths[side] / max(strengths.max(), 1e-12))
            if share < _WEAKEST:
                return
            self._add_gradient(moment, side, share, rank)

    def _add_gradient(self, moment: int, side: int, share: float, rank: int) -> None:
        """A gradient and its contact.

        Args:
            moment: The moment.
            side: Which side of the object is touched.
            share: Strength over that of the strongest gradient.
            rank: How many gradients are stronger.
        """
        recording = self._recording
        useful = recording.useful[moment, side]
        color = palette.TOWARDS if useful else palette.AWAY

        # Length and width grow with the strength.
        direction = recording.descents[moment, side] / recording.strengths[moment, side]
        arrow = (18.0 + 38.0 * np.sqrt(share)) * direction
        looks = {"facecolor": color, "edgecolor": "white", "linewidth": 0.8}
        self._add_arrow(moment, arrow, 1.4 + 5.2 * share, zorder=9 - rank / 10, looks=looks)

        # At a corner two contacts coincide: the smaller dot is on top.
        radius = 2.5 + 6.0 * float(recording.likelihoods[moment, side])
        x, y = recording.contacts[moment, side].tolist()
        dot = Circle((x, y), radius, facecolor=color, edgecolor="white")
        self._add(dot, zorder=10 - radius / 100)

    def _add_arrow(
        self, moment: int, arrow: FloatArray, width: float, zorder: float, looks: dict[str, Any]
    ) -> None:
        """An arrow from the edge of the pusher.

        Args:
            moment: The moment.
            arrow: From the arrow's tail to its tip, (2,), px.
            width: Width of the shaft, px.
            zorder: What is drawn later is on top.
            looks: Colours and line width.
        """
        length = float(np.linalg.norm(arrow))
        tail = self._recording.pushers[moment] + PUSHER_RADIUS * arrow / length
        head_width = 1.7 * width + 5.5

        patch = FancyArrow(
            *tail,
            *arrow,
            width=width,
            head_width=head_width,
            head_length=min(0.8 * head_width, 0.9 * length),
            length_includes_head=True,
            **looks,
        )
        self._add(patch, zorder)

    def _add_badge(self, exploring: bool) -> None:
        """Whether the pusher explores or descends."""
        box = {
            "boxstyle": "round,pad=0.32,rounding_size=0.7",
            "facecolor": palette.EXPLORING if exploring else palette.BADGE,
            "edgecolor": "none",
        }
        text = "exploring" if exploring else "descending"
        self._add_text((0.02, 0.962), text, color="white", va="top", fontweight="bold", bbox=box)

    def _add_text(self, place: tuple[float, float], text: str, **looks: Any) -> None:
        """A line of text at a place, in shares of the picture."""
        artist = self.axes.text(
            *place, text, transform=self.axes.transAxes, fontsize=10, zorder=12, **looks
        )
        self._artists.append(artist)


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
