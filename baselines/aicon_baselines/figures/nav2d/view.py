"""The world at one step: potential, arrows, belief and the agent's way."""

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Colormap, LinearSegmentedColormap, to_rgba
from matplotlib.image import AxesImage
from matplotlib.patches import Circle, Ellipse

from aicon_baselines.figures.nav2d.field import clearance, sample
from aicon_baselines.figures.nav2d.grid import Grid
from aicon_baselines.figures.nav2d.recording import FloatArray, Recording
from aicon_baselines.figures.nav2d.style import (
    AGENT,
    ARROW,
    BELIEF,
    EXPLORING,
    HEIGHT,
    MEAN_MARK,
    OBSTACLE,
    TARGET_MARK,
    TINT,
)


class View:
    """The world at one step, which can be brought to another step.

    Args:
        axes: Where to draw.
        recording: The rollout.
        grid: Where to sample.
    """

    def __init__(self, axes: Axes, recording: Recording, grid: Grid) -> None:
        self.axes, self._recording, self._grid = axes, recording, grid
        left, right, bottom, top = grid.extent
        axes.set(xlim=(left, right), ylim=(bottom, top), aspect="equal", xticks=[], yticks=[])
        axes.spines[:].set_color("0.6")
        self._heights = self._add_layer(HEIGHT, zorder=0)
        tint = LinearSegmentedColormap.from_list("tint", [to_rgba(EXPLORING, 0.0), to_rgba(EXPLORING, TINT)])
        self._tint = self._add_layer(tint, zorder=1)
        self._exploring = np.zeros(grid.shape)
        for vertices in recording.world.obstacles:
            axes.fill(*np.transpose(vertices), facecolor=OBSTACLE, edgecolor=OBSTACLE, linewidth=1.0, zorder=3)
        spacing = (right - left) / 27
        self._arrow_length = 0.72 * spacing
        self._arrow_points = _arrow_points(recording, grid, spacing)
        self._arrows = axes.quiver(
            *self._arrow_points.T,
            *np.zeros_like(self._arrow_points.T),
            pivot="middle",
            angles="xy",
            scale_units="xy",
            scale=1.0,
            width=0.0022,
            headwidth=4.2,
            headlength=4.6,
            headaxislength=4.0,
            color=ARROW,
            zorder=2,
        )
        (self._way,) = axes.plot([], [], color="white", linewidth=4.2, solid_capstyle="round", zorder=4)
        (self._trail,) = axes.plot([], [], color=AGENT, linewidth=2.2, solid_capstyle="round", zorder=5)
        self._belief = Ellipse((0, 0), 1, 1, facecolor=to_rgba(BELIEF, 0.13), edgecolor=BELIEF, linewidth=1.8, zorder=6)
        axes.add_patch(self._belief)
        axes.plot(*recording.world.target, **TARGET_MARK, zorder=7)
        (self._mean,) = axes.plot([], [], **MEAN_MARK, zorder=8)
        self._agent = Circle((0, 0), recording.radius, facecolor=AGENT, edgecolor="white", linewidth=1.2, zorder=9)
        axes.add_patch(self._agent)

    def show(self, step: int) -> None:
        """Bring the picture, and the time above it, to a step, 1 or later."""
        recording = self._recording
        self.axes.set_title(f"{recording.times[step]:.1f} s", loc="right", fontsize=10, color="0.35", pad=4)
        free = len(self._grid.points)
        field = sample(recording, step, np.concatenate([self._grid.points, self._arrow_points]))
        heights = self._grid.potential(field.descent[:free])
        self._heights.set_data(heights[self._grid.nearest_free])
        self._heights.set_clim(*np.nanpercentile(heights, (0.5, 99.5)))
        self._exploring = np.nan_to_num(self._grid.fill(field.exploring[:free].astype(np.float64)))
        self._tint.set_data(self._exploring)
        arrows = field.descent[free:]
        arrows = self._arrow_length * arrows / np.maximum(np.linalg.norm(arrows, axis=1, keepdims=True), 1e-9)
        self._arrows.set_UVC(*arrows.T)
        for line in (self._way, self._trail):
            line.set_data(*recording.positions[: step + 1].T)
        self._agent.set_center(recording.positions[step])
        mean, covariance = recording.belief(step)
        variances, directions = np.linalg.eigh(covariance)
        self._belief.set_center((float(mean[0]), float(mean[1])))
        self._belief.set_width(4 * math.sqrt(variances[1]))  # from −2σ to 2σ
        self._belief.set_height(4 * math.sqrt(variances[0]))
        self._belief.set_angle(math.degrees(math.atan2(directions[1, 1], directions[0, 1])))
        self._mean.set_data(*mean[:, np.newaxis])

    def entitle(self, title: str, size: float) -> None:
        """Write a title above the picture."""
        self.axes.set_title(title, loc="left", fontsize=size, pad=4)

    def outline(self) -> None:
        """Add the outline of where the agent would explore, which stays when the step changes."""
        if self._exploring.any():
            self.axes.contour(
                self._exploring, [0.5], extent=self._grid.extent, colors=EXPLORING, linewidths=0.9, zorder=1
            )

    def _add_layer(self, colours: Colormap, zorder: int) -> AxesImage:
        """Add values on the grid as colours, between 0 and 1 until other limits are set."""
        grid = self._grid
        return self.axes.imshow(
            np.zeros(grid.shape),
            cmap=colours,
            vmin=0,
            vmax=1,
            extent=grid.extent,
            origin="lower",
            interpolation="bilinear",
            zorder=zorder,
        )


def _arrow_points(recording: Recording, grid: Grid, spacing: float) -> FloatArray:
    """Positions of the arrows: a coarse grid, more than half the agent's radius away from the obstacles."""
    left, right, bottom, top = grid.extent
    points = np.stack(np.meshgrid(_centres(left, right, spacing), _centres(bottom, top, spacing)), axis=-1)
    points = points.reshape(-1, 2)
    clear: FloatArray = points[clearance(recording.world, recording.radius, points)[:, 0] > -0.5 * recording.radius]
    return clear


def _centres(low: float, high: float, spacing: float) -> FloatArray:
    """Centres of equal pieces of an interval, each about as long as the spacing."""
    count = round((high - low) / spacing)
    return (np.arange(count) + 0.5) * (high - low) / count + low
