"""What a figure looks like, as numbers."""

from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray


def pixels(figure: Figure) -> NDArray[np.uint8]:
    """The figure's picture, (height, width, 3)."""
    canvas: Any = FigureCanvasAgg(figure)  # matplotlib leaves its methods untyped
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[..., :3]
