"""A world in the plane, seen from above, and how gradients are drawn in it."""

from abc import abstractmethod
from collections.abc import Callable
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from aicon_baselines.view.canvas import HEIGHT, Canvas, FloatArray
from aicon_baselines.view.episode import LiveEpisode
from aicon_baselines.view.scene import FAINT, GradientArrow, Handle, Scene
from aicon_baselines.view.server import viser
from aicon_baselines.view.style import EXPLORING, RESOLVED, Color

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
        super().__init__(server, episode)
        self.canvas = Canvas(server, self.flipped)
        self._trail: list[FloatArray] = []

    def clear(self) -> None:
        """Remove everything that was drawn."""
        self.canvas.clear()
        self._trail = []

    @abstractmethod
    def draw_world(self) -> None:
        """Draw what an episode does not change, and fit the canvas to it."""

    def write(self, words: str) -> None:
        """Write a line above the world."""
        self.canvas.text("words", words, np.array([0.0, 0.45 * HEIGHT, 0.5]))

    def handle(self, where: Callable[[], FloatArray], move: Callable[[FloatArray], None]) -> Handle:
        """What a hand drags, by its place (2,) in the world."""
        return Handle(
            where=lambda: self.canvas.to_scene(where(), _HANDLE_LAYER),
            move=lambda position: move(self.canvas.to_world(position)),
        )

    def draw_arrows(self, position: ArrayLike) -> None:
        """Draw the gradients, and what becomes of them, where they act."""
        arrows, labelled = self.arrows(), self.labelled()
        strongest = max((arrow.strength for arrow in arrows), default=0.0)

        for index, arrow in enumerate(arrows):
            name = f"gradient.{index}"
            share = arrow.strength / strongest if strongest else 0.0
            shown = share > FAINT
            if shown:
                self._draw_arrow(name, position, arrow, share, index in labelled)
            else:
                self.canvas.hide(name)
                self.canvas.hide(f"{name}.source")
            if not shown or index not in labelled:
                self.canvas.hide(f"{name}.label")
        self._draw_resolved(position)

    def draw_trail(self, position: ArrayLike, color: Color, layer: float) -> None:
        """Draw where something has been since the start."""
        self._trail.append(np.array(position, np.float64))
        latest = self._trail[-self.trail_length :]
        self.canvas.line("trail", np.stack(latest), color, layer, thickness=3.0)

    def _draw_arrow(
        self,
        name: str,
        position: ArrayLike,
        arrow: GradientArrow,
        share: float,
        labelled: bool,
    ) -> None:
        """Draw a gradient, its label at the tip; its width is by its share of the strongest."""
        width = max(_WIDEST * share**0.5, 0.03)
        layer = _ARROW_LAYER + 1.0 - share
        self.canvas.arrow(name, position, arrow.direction, arrow.color, layer, _LONGEST, width)

        if arrow.source is not None:
            radius = 0.09 / self.canvas.scale
            self.canvas.disc(f"{name}.source", arrow.source, radius, arrow.color, layer)
        if not labelled:
            return

        flip = np.array([1.0, -1.0 if self.flipped else 1.0])
        along = arrow.direction[:2] * flip / np.linalg.norm(arrow.direction[:2])
        tip = self.canvas.to_scene(position, _ARROW_LAYER + 5)
        tip[:2] += 1.12 * _LONGEST * along
        self.canvas.text(f"{name}.label", arrow.label, tip)

    def _draw_resolved(self, position: ArrayLike) -> None:
        """Draw the motion that comes out, in another colour while it explores."""
        trace = self.episode.trace
        actuator = next(iter(self.episode.policy.model.actuators))
        action = trace.values[actuator][0].numpy(force=True)
        exploring = bool(self.episode.meeting.exploring[0])

        shown, other = ("exploring", "descending") if exploring else ("descending", "exploring")
        color = EXPLORING if exploring else RESOLVED
        layer = _ARROW_LAYER + 3
        self.canvas.hide(f"motion.{other}")
        self.canvas.arrow(f"motion.{shown}", position, action, color, layer, 1.25 * _LONGEST, 0.05)
