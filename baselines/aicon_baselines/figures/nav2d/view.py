"""The world at one step: potential, arrows, belief and the agent's trajectory."""

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Colormap, LinearSegmentedColormap, to_rgba
from matplotlib.contour import ContourSet
from matplotlib.image import AxesImage
from matplotlib.patches import Circle, Ellipse
from matplotlib.quiver import Quiver

from aicon_baselines import palette
from aicon_baselines.evaluation.recording import FloatArray
from aicon_baselines.figures.nav2d import style
from aicon_baselines.figures.nav2d.field import Field, clearance, sample
from aicon_baselines.figures.nav2d.grid import Grid
from aicon_baselines.figures.nav2d.recording import NavigationRecording
from aicon_baselines.figures.style import TARGET_MARK
from aicon_baselines.figures.view import WorldView

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
        self._add_world()
        self._add_agent()

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

    def _add_world(self) -> None:
        """Add what stays as it is: the obstacles and the target."""
        world = self._recording.world
        for vertices in world.obstacles:
            x, y = np.transpose(vertices)
            self.axes.fill(x, y, color=palette.OBSTACLE, linewidth=1.0, zorder=3)
        self.axes.plot(*world.target, **TARGET_MARK, zorder=7)

    def _add_agent(self) -> None:
        """Add the agent, its trajectory with a white edge, and where it believes the target."""
        axes = self.axes
        (edge,) = axes.plot([], [], color="white", linewidth=4.2, solid_capstyle="round", zorder=4)
        (trail,) = axes.plot(
            [], [], color=palette.ROBOT, linewidth=2.2, solid_capstyle="round", zorder=5
        )
        self._trajectory = (edge, trail)

        # Mean and ellipse of the belief.
        fill = to_rgba(palette.BELIEF, 0.13)
        self._ellipse = Ellipse(
            (0, 0), 1, 1, facecolor=fill, edgecolor=palette.BELIEF, linewidth=1.8, zorder=6
        )
        axes.add_patch(self._ellipse)
        (self._mean,) = axes.plot([], [], **style.MEAN_MARK, zorder=8)

        # The agent is as large as it is.
        self._agent = Circle(
            (0, 0),
            self._recording.radius,
            facecolor=palette.ROBOT,
            edgecolor="white",
            linewidth=1.2,
            zorder=9,
        )
        axes.add_patch(self._agent)

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
        self._agent.set_center(recording.positions[step])
        self._show_belief(step)

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

    def _show_belief(self, step: int) -> None:
        """Show the believed target, with an ellipse of two standard deviations."""
        mean, covariance = self._recording.belief(step)
        variances, directions = np.linalg.eigh(covariance)
        minor, major = 4 * np.sqrt(variances)  # from −2σ to 2σ
        x, y = directions[:, 1]

        self._ellipse.set_center((float(mean[0]), float(mean[1])))
        self._ellipse.set_width(major)
        self._ellipse.set_height(minor)
        self._ellipse.set_angle(math.degrees(math.atan2(y, x)))
        self._mean.set_data(*mean[:, np.newaxis])


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
