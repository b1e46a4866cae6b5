"""Shapes on paper: matplotlib's form of what :mod:`aicon_baselines.view.canvas` draws on a page."""

from collections.abc import Mapping

from matplotlib.axes import Axes
from matplotlib.colors import to_rgba
from matplotlib.patches import Polygon

from aicon_baselines.worlds.shape import Shape


class Paper:
    """Axes on which every shape has a name: drawn again, it moves.

    Args:
        axes: The axes.
    """

    def __init__(self, axes: Axes) -> None:
        self._axes = axes
        self._patches: dict[str, Polygon] = {}

    def clear(self) -> None:
        """Remove all shapes."""
        for patch in self._patches.values():
            patch.remove()
        self._patches.clear()

    def draw(self, shapes: Mapping[str, Shape]) -> None:
        """Draw shapes, or move them."""
        for name, shape in shapes.items():
            if name in self._patches:
                self._patches[name].set_xy(shape.points)
                continue

            self._patches[name] = Polygon(
                shape.points,
                facecolor=to_rgba(shape.color, shape.opacity) if shape.color else "none",
                edgecolor=shape.edge or "none",
                linewidth=shape.width,
                joinstyle="round",
                zorder=shape.layer,
                label=f"_{name}" if "." in name else name,
            )
            self._axes.add_patch(self._patches[name])
