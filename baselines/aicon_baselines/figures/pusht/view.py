"""The world at one moment: object, goal, pusher, contacts, and the gradients that meet at the pusher."""

from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgb
from matplotlib.patches import Circle, FancyArrow, Polygon

from aicon_baselines.figures.pusht.recording import FloatArray, Recording
from aicon_baselines.figures.pusht.style import (
    BADGE,
    DETRIMENTAL,
    EXPLORING,
    GOAL,
    GOAL_TINT,
    GROUND_TINT,
    INK,
    MOTION,
    OBJECT,
    OUTLINE,
    PUSHER,
    USEFUL,
    WALL,
)
from aicon_envs.pusht.geometry import place
from aicon_envs.pusht.simulation import PUSHER_RADIUS, WALL_HIGH, WALL_LOW

ASPECT = 1.5  # width of a view over its height
_MARGIN = 10.0  # px around what is shown
_ARROWS = 4  # gradients to show at most
_WEAKEST = 0.06  # and as strong as this share of the strongest
_SHORTEST = 16.0  # px that the arrow of the commanded motion is long at least
_FADING = 12  # steps until the way is pale


class View:
    """The world at one moment, which can be brought to another.

    Args:
        axes: Where to draw.
        recording: The episode.
    """

    def __init__(self, axes: Axes, recording: Recording) -> None:
        self.axes, self._recording = axes, recording
        self._artists: list[Artist] = []
        (left, top), (right, bottom) = _frame(recording)
        axes.set(xlim=(left, right), ylim=(bottom, top), aspect="equal", xticks=[], yticks=[], facecolor=WALL)
        axes.spines[:].set_color("0.6")
        floor = [(WALL_LOW, WALL_LOW), (WALL_HIGH, WALL_LOW), (WALL_HIGH, WALL_HIGH), (WALL_LOW, WALL_HIGH)]
        self._floor = Polygon(floor, edgecolor="none", zorder=0)
        axes.add_patch(self._floor)
        goal = place(recording.outline, recording.goal)
        axes.add_patch(Polygon(goal, facecolor=_pale(GOAL, GOAL_TINT), edgecolor="none", zorder=1))
        axes.add_patch(Polygon(goal, fill=False, edgecolor=GOAL, linewidth=2.2, joinstyle="round", zorder=4))

    def show(self, moment: int) -> None:
        """Bring the picture, and the time above it, to a moment."""
        for artist in self._artists:
            artist.remove()
        self._artists = []
        recording = self._recording
        exploring = bool(recording.exploring[moment]) and moment < recording.steps
        self.axes.set_title(f"{recording.times[moment]:.1f} s", loc="right", fontsize=11, color="0.35", pad=4)
        self._floor.set_facecolor(_pale(EXPLORING, GROUND_TINT) if exploring else "white")
        object_now = Polygon(recording.corners(moment), facecolor=OBJECT, edgecolor=OUTLINE, linewidth=1.4)
        self._add(object_now, zorder=2)
        self._add_way(moment)
        pusher = Circle(_point(recording.pushers[moment]), PUSHER_RADIUS, facecolor=PUSHER, edgecolor="white")
        self._add(pusher, zorder=8)
        self._add_text((0.02, 0.04), f"g = {recording.costs[moment]:.0f} px", color="0.35", va="bottom")
        if moment < recording.steps:
            self._add_motion(moment)
            self._add_gradients(moment)
            self._add_badge(exploring)

    def entitle(self, title: str, size: float) -> None:
        """Write a title above the picture."""
        self.axes.set_title(title, loc="left", fontsize=size, pad=4)

    def _add(self, artist: Any, zorder: float) -> None:
        """Add what the next moment removes."""
        artist.set_zorder(zorder)
        self._artists.append(self.axes.add_artist(artist))

    def _add_way(self, moment: int) -> None:
        """The pusher's way so far, the paler the longer ago."""
        ages = np.arange(moment)[::-1]
        colours = [_pale(PUSHER, float(share)) for share in 0.2 + 0.6 * np.clip(1 - ages / _FADING, 0, 1)]
        ways = list(self._recording.ways[:moment])
        self._add(LineCollection(ways, colors=colours, linewidths=2.2, capstyle="round", joinstyle="round"), zorder=3)

    def _add_motion(self, moment: int) -> None:
        """The displacement that is commanded for the step to come, as long as it is in the world."""
        motion = self._recording.motions[moment]
        length = float(np.linalg.norm(motion))
        way = motion / max(length, 1e-9) * max(length, _SHORTEST)
        self._add_arrow(moment, way, 15.0, MOTION, zorder=7, edgecolor=INK, linewidth=1.5)

    def _add_gradients(self, moment: int) -> None:
        """The strongest gradients as arrows downhill, and their contacts, the larger the likelier."""
        recording = self._recording
        strengths = recording.strengths[moment]
        for rank, side in enumerate(np.argsort(-strengths)[:_ARROWS]):
            share = strengths[side] / max(strengths.max(), 1e-12)
            if share < _WEAKEST:
                return
            colour = USEFUL if recording.useful[moment, side] else DETRIMENTAL
            way = (18.0 + 38.0 * np.sqrt(share)) * recording.descents[moment, side] / strengths[side]
            self._add_arrow(moment, way, 1.4 + 5.2 * share, colour, zorder=9 - rank / 10)
            radius = 2.5 + 6.0 * float(recording.likelihoods[moment, side])
            dot = Circle(_point(recording.contacts[moment, side]), radius, facecolor=colour, edgecolor="white")
            self._add(dot, zorder=10 - radius / 100)  # at a corner two contacts coincide: the smaller is on top

    def _add_arrow(
        self, moment: int, way: FloatArray, width: float, colour: str, zorder: float, **outline: Any
    ) -> None:
        """An arrow from the edge of the pusher along a way, px; its width is that of its shaft, px."""
        length = float(np.linalg.norm(way))
        start = self._recording.pushers[moment] + PUSHER_RADIUS * way / length
        head = 1.7 * width + 5.5
        looks: dict[str, Any] = {"facecolor": colour, "edgecolor": "white", "linewidth": 0.8} | outline
        arrow = FancyArrow(
            *start,
            *way,
            width=width,
            head_width=head,
            head_length=min(0.8 * head, 0.9 * length),
            length_includes_head=True,
            **looks,
        )
        self._add(arrow, zorder=zorder)

    def _add_badge(self, exploring: bool) -> None:
        """Whether the pusher explores or descends."""
        box = {"boxstyle": "round,pad=0.32,rounding_size=0.7", "facecolor": EXPLORING if exploring else BADGE}
        label = "exploring" if exploring else "descending"
        self._add_text(
            (0.02, 0.962), label, color="white", va="top", fontweight="bold", bbox=box | {"edgecolor": "none"}
        )

    def _add_text(self, place: tuple[float, float], text: str, **looks: Any) -> None:
        """A line of text at a place, in shares of the picture."""
        self._artists.append(
            self.axes.text(*place, text, transform=self.axes.transAxes, fontsize=10, zorder=12, **looks)
        )


def _frame(recording: Recording) -> tuple[FloatArray, FloatArray]:
    """Upper left and lower right corner of the smallest frame of a view's aspect around all that is shown, px."""
    moments = range(recording.steps + 1)
    objects = [recording.corners(moment) for moment in moments]
    discs = [recording.pushers - PUSHER_RADIUS, recording.pushers + PUSHER_RADIUS]
    points = np.concatenate([place(recording.outline, recording.goal), *objects, *discs])
    low, high = points.min(axis=0) - _MARGIN, points.max(axis=0) + _MARGIN
    width, height = high - low
    size = np.array([max(width, ASPECT * height), max(height, width / ASPECT)])
    return (low + high - size) / 2, (low + high + size) / 2


def _pale(colour: str, share: float) -> tuple[float, float, float]:
    """A colour of some opacity on white, but opaque, so that what overlaps does not show."""
    red, green, blue = (1 - share * (1 - channel) for channel in to_rgb(colour))
    return red, green, blue


def _point(vector: FloatArray) -> tuple[float, float]:
    x, y = vector.tolist()
    return x, y
