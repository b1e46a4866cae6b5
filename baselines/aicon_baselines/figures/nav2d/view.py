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
from aicon_baselines.figures.nav2d import style
from aicon_baselines.figures.nav2d.field import Field, clearance, sample
from aicon_baselines.figures.nav2d.grid import Grid
from aicon_baselines.figures.nav2d.recording import NavigationRecording
from aicon_baselines.figures.view import WorldView
from aicon_baselines.worlds import believed, disc, navigation
from aicon_baselines.worlds.paper import Paper
from aicon_baselines.worlds.surroundings import ARRIVAL

_ARROWS_PER_ROW = 27


class NavigationView(WorldView):
    """The world at one step.

    Args:
        axes: Where to draw.
        recording: The rollout.
        grid: Where to sample.
        outline: Whether to outline where the agent would explore.
    """

    def __init__(
        self, axes: Axes, recording: NavigationRecording, grid: Grid, *, outline: bool = False
    ) -> None:
        super().__init__(axes)
        self._recording, self._grid, self._outlined = recording, grid, outline
        left, right, bottom, top = grid.extent
        axes.set(xlim=(left, right), ylim=(bottom, top))

        # The potential, and a tint where the agent would explore.
        clear, tint = to_rgba(palette.EXPLORING, 0.0), to_rgba(palette.EXPLORING, style.TINT)
        self._heights = self._add_layer(style.HEIGHT, zorder=0)
        self._tint = self._add_layer(
            LinearSegmentedColormap.from_list("tint", [clear, tint]), zorder=1
        )
        self._outline: ContourSet | None = None

        # Arrows on a coarser grid.
        spacing = (right - left) / _ARROWS_PER_ROW
        self._arrow_length = 0.72 * spacing
        self._arrow_points = _arrow_points(recording, grid, spacing)
        self._arrows = self._add_arrows()

        # What is in the world, above both.
        self._paper = Paper(axes)
        self._paper.draw(navigation(recording.world.obstacles, recording.world.target))
        self._add_trajectory()

    def _add_layer(self, colors: Colormap, zorder: int) -> AxesImage:
        """Add values on the grid as colours, between 0 and 1 until other limits are set."""
        grid = self._grid
        return self.axes.imshow(
            np.zeros(grid.shape),
            cmap=colors,
            vmin=0,
            vmax=1,
            extent=grid.extent,
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
            color=style.ARROW,
            zorder=2,
        )

    def _add_trajectory(self) -> None:
        """Add the agent's trajectory with a white edge."""
        looks: dict[str, Any] = {"solid_capstyle": "round"}
        (edge,) = self.axes.plot([], [], color="white", linewidth=4.2, zorder=4, **looks)
        (trail,) = self.axes.plot([], [], color=palette.ROBOT, linewidth=2.2, zorder=5, **looks)
        self._trajectory = (edge, trail)

    def show(self, step: int) -> None:
        """Bring the picture, and the time above it, to a step, 1 or later."""
        recording = self._recording
        self.set_time(recording.times[step], size=10)

        # One sample of the field for both, the grid and the arrows.
        points = np.concatenate([self._grid.points, self._arrow_points])
        field = sample(recording, step, points)
        on_grid = len(self._grid.points)
        self._show_potential(Field(field.descent[:on_grid], field.exploring[:on_grid]))
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

    def _show_potential(self, field: Field) -> None:
        """Show the potential that fits a field on the grid, and where the agent would explore."""
        grid = self._grid
        # Within obstacles it goes on as at their edge, so that no light seam shows.
        heights = grid.potential(field.descent)
        self._heights.set_data(heights[grid.nearest_free])
        self._heights.set_clim(*np.nanpercentile(heights, (0.5, 99.5)))

        exploring = np.nan_to_num(grid.fill(field.exploring.astype(np.float64)))
        self._tint.set_data(exploring)
        if self._outlined:
            self._show_outline(exploring)

    def _show_outline(self, exploring: FloatArray) -> None:
        """Outline where values on the grid are 1 and not 0."""
        if self._outline is not None:
            self._outline.remove()
            self._outline = None

        if exploring.any():
            self._outline = self.axes.contour(
                exploring,
                [0.5],
                extent=self._grid.extent,
                colors=palette.EXPLORING,
                linewidths=0.9,
                zorder=1,
            )

    def _show_arrows(self, descent: FloatArray) -> None:
        """Point the arrows along the descent, all of one length."""
        norms = np.linalg.norm(descent, axis=1, keepdims=True)
        arrows = self._arrow_length * descent / np.maximum(norms, 1e-9)
        self._arrows.set_UVC(*arrows.T)


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
