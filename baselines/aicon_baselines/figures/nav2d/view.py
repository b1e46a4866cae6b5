"""The world at one step: potential, arrows, belief and the agent's trajectory."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Colormap, LinearSegmentedColormap, to_rgba
from matplotlib.contour import ContourSet
from matplotlib.image import AxesImage
from matplotlib.quiver import Quiver

from aicon_baselines import palette
from aicon_baselines.evaluation.recording import FloatArray
from aicon_baselines.figures.nav2d.field import clearance, sample
from aicon_baselines.figures.nav2d.grid import Grid
from aicon_baselines.figures.nav2d.recording import NavigationRecording
from aicon_baselines.figures.view import WorldView, rectangle_around
from aicon_baselines.worlds import believed, disc, navigation
from aicon_baselines.worlds.paper import Paper
from aicon_baselines.worlds.surroundings import ARRIVAL

ASPECT = 1.95
"""Width of the picture over its height."""

HEIGHT = LinearSegmentedColormap.from_list(
    "height", ["#fdfcf5", "#dfeae2", "#b5d2cb", "#86b3b1", "#5b8f96", "#3f6d7a"]
)
"""Colours of the potential, from low to high."""

TINT = 0.24
"""Opacity of what says "exploring"."""

_MARGIN = 0.45  # m of free space around what is shown
_ARROW = "#23454f"
_ARROWS_PER_ROW = 27


class NavigationView(WorldView):
    """The world at one step.

    Args:
        axes: Where to draw.
        recording: The rollout, whose trajectory, target and obstacles are to be seen.
        spacing: Distance of the positions at which the potential is sampled, m.
    """

    def __init__(self, axes: Axes, recording: NavigationRecording, spacing: float) -> None:
        super().__init__(axes)
        self._recording = recording
        self._grid = _grid_around(recording, spacing)
        left, right, bottom, top = self._grid.extent
        axes.set(xlim=(left, right), ylim=(bottom, top))

        # The potential, and a tint where the agent would explore.
        clear, tint = to_rgba(palette.EXPLORING, 0.0), to_rgba(palette.EXPLORING, TINT)
        tints = LinearSegmentedColormap.from_list("tint", [clear, tint])
        self._heights = self._add_layer(HEIGHT, zorder=0)
        self._tint = self._add_layer(tints, zorder=1)
        self._outline: ContourSet | None = None

        # Arrows on a coarser grid.
        arrow_spacing = (right - left) / _ARROWS_PER_ROW
        self._arrow_length = 0.72 * arrow_spacing
        self._arrow_points = _arrow_points(recording, self._grid, arrow_spacing)
        self._arrows = self._add_arrows()

        # What is in the world, above both; the trajectory has a white edge.
        self._paper = Paper(axes)
        self._paper.draw(navigation(recording.world.obstacles, recording.world.target))
        looks: dict[str, Any] = {"solid_capstyle": "round"}
        edge = axes.plot([], [], color="white", linewidth=4.2, zorder=4, **looks)
        trail = axes.plot([], [], color=palette.ROBOT, linewidth=2.2, zorder=5, **looks)
        self._trajectory = edge + trail

    def _add_layer(self, colors: Colormap, zorder: int) -> AxesImage:
        """Add values on the grid as colours, between 0 and 1 until other limits are set."""
        return self.axes.imshow(
            np.zeros(self._grid.shape),
            cmap=colors,
            vmin=0,
            vmax=1,
            extent=self._grid.extent,
            origin="lower",
            interpolation="bilinear",
            zorder=zorder,
        )

    def _add_arrows(self) -> Quiver:
        """Add arrows, without length until the first step is shown."""
        return self.axes.quiver(
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
            color=_ARROW,
            zorder=2,
        )

    def show(self, step: int) -> None:
        """Bring the picture, and the time above it, to a step, 1 or later."""
        recording, grid = self._recording, self._grid
        self.set_time(recording.times[step])

        # One sample of the field for both, the grid and the arrows.
        field = sample(recording, step, np.concatenate([grid.points, self._arrow_points]))
        on_grid = len(grid.points)
        self._show_potential(field.descent[:on_grid])
        self._show_exploration(grid.fill(field.exploring[:on_grid].astype(np.float64)))
        self._show_arrows(field.descent[on_grid:])

        # The agent, where it has been, and what it believes.
        for line in self._trajectory:
            line.set_data(*recording.positions[: step + 1].T)
        mean, covariance = recording.belief(step)
        self._paper.draw(
            {
                "agent": disc(recording.positions[step], recording.radius, 9, palette.ROBOT),
                "belief": believed(mean, covariance, 6, palette.BELIEF),
                "belief.mean": disc(mean, 0.4 * ARRIVAL, 8, palette.BELIEF),
            }
        )

    def _show_potential(self, descent: FloatArray) -> None:
        """Show the potential that fits a field on the grid."""
        # Within obstacles it goes on as at their edge, so that no light seam shows.
        heights = self._grid.potential(descent)
        self._heights.set_data(heights[self._grid.nearest_free])
        self._heights.set_clim(*np.nanpercentile(heights, (0.5, 99.5)))

    def _show_exploration(self, exploring: FloatArray) -> None:
        """Tint and outline where the agent would explore: where values on the grid are 1."""
        exploring = np.nan_to_num(exploring)
        self._tint.set_data(exploring)

        if self._outline is not None:
            self._outline.remove()
            self._outline = None
        if exploring.any():
            looks: dict[str, Any] = {"colors": palette.EXPLORING, "linewidths": 0.9, "zorder": 1}
            self._outline = self.axes.contour(exploring, [0.5], extent=self._grid.extent, **looks)

    def _show_arrows(self, descent: FloatArray) -> None:
        """Point the arrows along the descent, all of one length."""
        norms = np.linalg.norm(descent, axis=1, keepdims=True)
        arrows = self._arrow_length * descent / np.maximum(norms, 1e-9)
        self._arrows.set_UVC(*arrows.T)


def _grid_around(recording: NavigationRecording, spacing: float) -> Grid:
    """A grid over the smallest rectangle that shows all there is."""
    world = recording.world
    points = np.concatenate([recording.positions, [world.target], *world.obstacles])
    low, high = rectangle_around(points, _MARGIN, ASPECT)
    return Grid(world, low, high, spacing)


def _arrow_points(recording: NavigationRecording, grid: Grid, spacing: float) -> FloatArray:
    """Positions of the arrows: a coarse grid, half the agent's radius or more from obstacles."""
    left, right, bottom, top = grid.extent
    centers = np.meshgrid(_centers(left, right, spacing), _centers(bottom, top, spacing))
    points = np.stack(centers, axis=-1).reshape(-1, 2)

    distances = clearance(recording.world, recording.radius, points)[:, 0]
    clear: FloatArray = points[distances > -0.5 * recording.radius]
    return clear


def _centers(low: float, high: float, spacing: float) -> FloatArray:
    """Centres of equal pieces of an interval, each about as long as the spacing."""
    count = round((high - low) / spacing)
    return (np.arange(count) + 0.5) * (high - low) / count + low
