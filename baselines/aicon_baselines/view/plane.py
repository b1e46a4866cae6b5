"""A world in the plane, seen from above, and how gradients are drawn in it."""

from collections.abc import Callable
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from aicon_baselines import worlds
from aicon_baselines.view.canvas import HEIGHT, Canvas
from aicon_baselines.view.episode import LiveEpisode
from aicon_baselines.view.marks import FloatArray
from aicon_baselines.view.scene import GradientArrow, Handle, Scene
from aicon_baselines.view.server import viser

_LONGEST = 0.15 * HEIGHT  # length of an arrow
_WIDEST = 0.16  # width of the strongest
_ARROW_LAYER = 20.0
_HANDLE_LAYER = 40.0


class PlaneScene(Scene):
    """A world in the plane, on a canvas.

    Args:
        server: The server of the page.
        episode: The episode, started.

    Attributes:
        canvas: Where it is drawn.
    """

    trail_length: ClassVar[int] = 1000
    """How many pictures back the trail goes."""

    flipped: ClassVar[bool] = False
    """Whether y points down."""

    def __init__(self, server: viser.ViserServer, episode: LiveEpisode) -> None:
        self.canvas = Canvas(server, self.flipped)
        super().__init__(server, episode, self.canvas, words_at=(0.0, 0.45 * HEIGHT, 0.5))
        self._trail: list[FloatArray] = []

    def clear(self) -> None:
        """Remove everything that was drawn."""
        super().clear()
        self._trail = []

    def handle(self, where: Callable[[], FloatArray], move: Callable[[FloatArray], None]) -> Handle:
        """What a hand drags, by its place (2,) in the world."""
        return Handle(
            where=lambda: self.canvas.to_scene(where(), _HANDLE_LAYER),
            move=lambda position: move(self.canvas.to_world(position)),
        )

    def draw_trail(self, position: ArrayLike, color: str, layer: float) -> None:
        """Draw where something has been since the start."""
        self._trail.append(np.array(position, np.float64))
        latest = self._trail[-self.trail_length :]
        self.canvas.line("trail", np.stack(latest), color, layer, thickness=3.0)

    def draw_arrow(
        self, name: str, tail: ArrayLike, arrow: GradientArrow, share: float
    ) -> FloatArray | None:
        """Draw a gradient, all of one length; the wider ones lie below."""
        norm = np.linalg.norm(arrow.direction[:2])
        if norm == 0.0:
            return None

        unit, layer = 1.0 / self.canvas.scale, _ARROW_LAYER + 1.0 - share
        width = max(_WIDEST * share**0.5, 0.03)
        head = 1.1 * max(2.6 * width, 0.16)
        along = arrow.length * _LONGEST * unit / norm * arrow.direction[:2]
        shape = worlds.arrow(tail, along, unit * width, unit * head, layer, arrow.color)
        self.canvas.draw({name: shape})
        if arrow.source is not None:
            source = worlds.disc(arrow.source, 0.09 * unit, layer, arrow.color)
            self.canvas.draw({f"{name}.source": source})

        # Beyond the tip.
        return self.canvas.to_scene(np.asarray(tail) + 1.12 * along, _ARROW_LAYER + 5)
