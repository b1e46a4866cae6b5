"""What every world of the view offers, and how gradients are drawn in it."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from aicon_baselines.view.canvas import HEIGHT, Canvas, FloatArray
from aicon_baselines.view.episode import LiveEpisode
from aicon_baselines.view.server import viser
from aicon_baselines.view.style import EXPLORING, RESOLVED, Color

_LONGEST = 0.15 * HEIGHT  # length of an arrow
_WIDEST = 0.16  # width of the strongest
_FEW = 3  # gradients that are all labelled
_FAINT = 0.02  # share of the strongest below which an arrow is not drawn
_ARROW_LAYER = 20.0


@dataclass(frozen=True)
class GradientArrow:
    """A gradient as it is drawn.

    Attributes:
        label: What it wants, in two or three words.
        color: Its colour.
        direction: Where it would go, (2,), in the world's frame.
        strength: Its magnitude.
        source: What it comes from, a point (2,) that is marked; None for nothing to mark.
    """

    label: str
    color: Color
    direction: FloatArray
    strength: float
    source: FloatArray | None = None


class Scene(ABC):
    """The world of a task in the plane, on a canvas.

    Args:
        server: The server of the page.
        episode: The episode, started.

    Attributes:
        canvas: Where it is drawn.
    """

    title: ClassVar[str]
    """What happens in this world, in a sentence."""

    legend: ClassVar[dict[str, Color]]
    """What each colour says."""

    curves: ClassVar[Mapping[str, Color]]
    """The curves of strengths, with their colours."""

    hint: ClassVar[str]
    """What a hand can do."""

    trail_length: ClassVar[int]
    """How many pictures back the trail goes."""

    flipped: ClassVar[bool] = False
    can_kick: ClassVar[bool] = False

    def __init__(self, server: viser.ViserServer, episode: LiveEpisode) -> None:
        self.server, self.episode = server, episode
        self.canvas = Canvas(server, self.flipped)
        self._grip: viser.TransformControlsHandle | None = None

    def start(self) -> None:
        """Draw a new episode from nothing."""
        self.canvas.clear()
        self._trail: list[FloatArray] = []
        self.draw_world()
        self.draw()
        if self._grip is not None:
            self._place_grip()

    def draw(self) -> None:
        """Bring everything that moves to the present."""
        with self.server.atomic():
            self.draw_moving()

    @abstractmethod
    def draw_world(self) -> None:
        """Draw what an episode does not change, and fit the canvas to it."""

    @abstractmethod
    def draw_moving(self) -> None:
        """Draw what moves: robot, object, beliefs, gradients."""

    @abstractmethod
    def arrows(self) -> list[GradientArrow]:
        """The gradients that meet."""

    @abstractmethod
    def strengths(self) -> dict[str, float]:
        """The strengths at this moment, by curve."""

    @abstractmethod
    def distance_left(self) -> str:
        """How far it is to the target, in words."""

    @abstractmethod
    def target(self) -> tuple[FloatArray, float]:
        """Where the target is, (2,), and its angle, rad, in the world's frame."""

    @abstractmethod
    def move_target(self, position: FloatArray, angle: float) -> None:
        """Put the target elsewhere; the episode goes on.

        Raises:
            ValueError: If it cannot be there.
        """

    def draw_words(self) -> None:
        """Write what happens into the world, for a page without a panel."""
        episode = self.episode
        if episode.ended:
            words = "arrived" if episode.info["is_success"][0] else "ended"
        elif bool(self.episode.meeting.exploring[0]):
            words = f"exploring: {self.conflict()}"
        else:
            words = f"descending: {self.arrows()[int(self.episode.meeting.leader[0])].label}"
        position = np.array([0.0, 0.48 * HEIGHT, 0.5])
        self.canvas.text("words", f"{episode.time:.1f} s, {words}", position)

    def kick(self) -> None:
        """Displace the object, in worlds that have one."""
        raise ValueError("there is nothing to kick in this world")

    def conflict(self) -> str:
        """What opposes what, in words, while it explores."""
        meeting, arrows = self.episode.meeting, self.arrows()
        opponent = int(meeting.opponent[0])
        leader = arrows[int(meeting.leader[0])].label
        if opponent < 0 or meeting.goals_in_conflict(0) is None:
            return f"{leader}, until it gets on"
        return f"{leader} ↔ {arrows[opponent].label}"

    def add_grip(self, ask: Callable[[Callable[[], None]], None]) -> None:
        """Add the handle by which a hand moves the target.

        Args:
            ask: Has something done between two steps.
        """
        self._grip = grip = self.server.scene.add_transform_controls(
            "/grip",
            scale=0.9,
            active_axes=(True, True, False),
            disable_rotations=True,
            depth_test=False,
            opacity=0.7,
        )
        self._place_grip()

        @grip.on_update
        def _(event: Any) -> None:
            if event.phase == "end":
                ask(self._take_grip)

    def _take_grip(self) -> None:
        """Put the target where the handle is; where that cannot be, the handle goes back."""
        assert self._grip is not None
        position = self.canvas.to_world(self._grip.position)
        try:
            self.move_target(position, self.target()[1])
        finally:
            self._place_grip()

    def _place_grip(self) -> None:
        """Put the handle where the target is."""
        assert self._grip is not None
        position, _ = self.target()
        self._grip.position = self.canvas.to_scene(position, 40)

    def draw_arrows(self, position: ArrayLike) -> None:
        """Draw the gradients, and what becomes of them, where they act."""
        arrows = self.arrows()
        strongest = max((arrow.strength for arrow in arrows), default=0.0)

        # Where there are many, only the two that are compared have their words.
        meeting = self.episode.meeting
        compared = {int(meeting.leader[0]), int(meeting.opponent[0])}
        for index, arrow in enumerate(arrows):
            name = f"gradient.{index}"
            share = arrow.strength / strongest if strongest else 0.0
            labelled = len(arrows) <= _FEW or index in compared
            if share > _FAINT:
                self._draw_arrow(name, position, arrow, share, labelled)
            else:
                self.canvas.hide(name)
                self.canvas.hide(f"{name}.source")
            if share <= _FAINT or not labelled:
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
        along = arrow.direction * flip / np.linalg.norm(arrow.direction)
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
