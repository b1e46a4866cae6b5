"""What a camera saw, picture by picture."""

from collections.abc import Sequence

from matplotlib.axes import Axes

from aicon_baselines.figures.rendering import Frame
from aicon_baselines.figures.view import WorldView


class CameraView(WorldView):
    """The pictures of a camera, one at a time.

    Args:
        axes: Where to draw.
        title: What is above the picture.
        pictures: The pictures, (H, W, 3) each.
    """

    def __init__(self, axes: Axes, title: str, pictures: Sequence[Frame]) -> None:
        super().__init__(axes)
        axes.set_axis_off()
        axes.set_title(title, fontsize=10)
        self._pictures = pictures
        self._image = axes.imshow(pictures[0])

    def show(self, step: int) -> None:
        """Show a picture."""
        self._image.set_data(self._pictures[step])
