"""What every world of the view offers: what it shows, what it says and what a hand can move."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from aicon_baselines.palette import EXPLORING, GOALS, RESOLVED
from aicon_baselines.view.episode import LiveEpisode
from aicon_baselines.view.marks import FloatArray, Marks
from aicon_baselines.view.server import viser

Request = Callable[[Callable[[], None]], None]
"""Has something done between two steps."""

FAINT = 0.02
"""Share of the strongest gradient below which another is not drawn."""

_FEW = 3  # gradients that are all labelled
_MOTION = 0.1  # share of the strongest gradient that the arrow of the motion is as wide as


@dataclass(frozen=True)
class GradientArrow:
    """A gradient as it is drawn.

    Attributes:
        label: What it wants, in two or three words.
        color: Its colour.
        direction: Where it would go, (2,) or (3,), in the world's frame.
        strength: Its magnitude.
        source: What it comes from, a point that is marked; None for nothing to mark.
        length: In comparison with other arrows.
    """

    label: str
    color: str
    direction: FloatArray
    strength: float = 0.0
    source: FloatArray | None = None
    length: float = 1.0


@dataclass(frozen=True)
class Handle:
    """Something that a hand can drag.

    Attributes:
        where: Returns where it is in the scene, (3,).
        move: Puts it to a place in the scene, (3,), or raises a ValueError if it cannot be there.
        axes: Along which axes of the scene it can be dragged.
    """

    where: Callable[[], FloatArray]
    move: Callable[[FloatArray], None]
    axes: tuple[bool, bool, bool] = (True, True, False)


class Scene(ABC):
    """The world of an episode.

    Only the two methods that draw have to be written; what else a world can tell and offer has
    defaults that fit any graph.

    Args:
        server: The server of the page.
        episode: The episode, started.
        marks: What it is drawn with.
        words_at: Where a line of words is written in the scene, (3,).
    """

    title: ClassVar[str] = ""
    """What happens in this world, in a sentence."""

    legend: ClassVar[Mapping[str, str]] = {}
    """What each colour says."""

    curves: ClassVar[Mapping[str, str]] = {}
    """The curves of strengths, with their colours; by default one for each goal."""

    remaining_curves: ClassVar[Mapping[str, str]] = {}
    """The curves of what is left to do, by their names in `info`, with their colours."""

    hint: ClassVar[str] = ""
    """What a hand can do."""

    can_kick: ClassVar[bool] = False
    handle_size: ClassVar[float] = 0.9
    """Size of a handle, in units of the scene."""

    def __init__(
        self, server: viser.ViserServer, episode: LiveEpisode, marks: Marks, words_at: ArrayLike
    ) -> None:
        self.server, self.episode = server, episode
        self._marks, self._words_at = marks, words_at
        self._grips: dict[str, viser.TransformControlsHandle] = {}
        self._dragged: set[str] = set()

    def clear(self) -> None:
        """Remove everything that was drawn."""
        self._marks.clear()

    @abstractmethod
    def draw_world(self) -> None:
        """Draw what an episode does not change."""

    @abstractmethod
    def draw_moving(self) -> None:
        """Draw what moves: robot, object, beliefs, gradients."""

    @abstractmethod
    def draw_arrow(
        self, name: str, tail: ArrayLike, arrow: GradientArrow, share: float
    ) -> FloatArray | None:
        """Draw a gradient from a point of the world on, as wide as its share of the strongest.

        Returns:
            Where its label stands in the scene, (3,); None if it has no direction.
        """

    def way(self, quantity: str, vector: FloatArray) -> FloatArray:
        """The direction in the world of a vector at a quantity; by default it is the same."""
        return vector

    def write(self, words: str) -> None:
        """Write a line above the world."""
        self._marks.text("words", words, self._words_at)

    def start(self) -> None:
        """Draw a new episode from nothing."""
        self.clear()
        self.draw_world()
        self.draw()

    def draw(self) -> None:
        """Bring everything that moves to the present."""
        with self.server.atomic():
            self.draw_moving()
            self._place_grips()

    def draw_arrows(self, tail: ArrayLike) -> None:
        """Draw the gradients, and what becomes of them, where they act."""
        arrows, labelled = self.arrows(), self.labelled()
        strongest = max((arrow.strength for arrow in arrows), default=0.0)

        for index, arrow in enumerate(arrows):
            name = f"gradient.{index}"
            share = arrow.strength / strongest if strongest else 0.0
            label = self.draw_arrow(name, tail, arrow, share) if share > FAINT else None

            if label is None:
                self._marks.hide(name, f"{name}.label", f"{name}.source")
            elif index in labelled:
                self._marks.text(f"{name}.label", arrow.label, label)
            else:
                self._marks.hide(f"{name}.label")

        # The motion that comes out, in another colour while it explores.
        trace = self.episode.trace
        actuator = next(iter(self.episode.policy.model.actuators))
        exploring = any(bool(quantity.exploring[0]) for quantity in trace.quantities.values())
        action = trace.values[actuator][0].numpy(force=True)
        color = EXPLORING if exploring else RESOLVED
        motion = GradientArrow("", color, self.way(actuator, action), length=1.25)
        if self.draw_arrow("motion", tail, motion, _MOTION) is None:
            self._marks.hide("motion")

    def arrows(self) -> list[GradientArrow]:
        """The gradients that meet."""
        meeting = self.episode.meeting
        gradients = meeting.gradients[0].numpy(force=True)
        strengths = meeting.magnitudes[0].tolist()

        found = []
        for index, gradient in enumerate(gradients):
            label, color = self.look_of(meeting.paths[index], meeting.goals[index])
            direction = self.way(meeting.name, -gradient)
            found.append(GradientArrow(label, color, direction, strengths[index]))
        return found

    def look_of(self, path: tuple[str, ...], goals: tuple[str, ...]) -> tuple[str, str]:
        """What a gradient wants, in words, and its colour; by default each goal has its own."""
        return " + ".join(goals), self.goal_color(goals[0])

    def goal_color(self, goal: str) -> str:
        """The colour of a goal, by its number."""
        return GOALS[list(self.episode.policy.model.goals).index(goal) % len(GOALS)]

    def strength_curves(self) -> Mapping[str, str]:
        """The curves of strengths, with their colours."""
        if self.curves:
            return self.curves
        return {goal: self.goal_color(goal) for goal in self.episode.policy.model.goals}

    def strengths(self) -> dict[str, float]:
        """The strengths at this moment, by curve: the strongest gradient of each goal alone."""
        strongest = dict.fromkeys(self.strength_curves(), 0.0)
        for met in self.episode.trace.quantities.values():
            for goals, strength in zip(met.goals, met.magnitudes[0].tolist(), strict=True):
                if len(goals) == 1:
                    strongest[goals[0]] = max(strongest[goals[0]], strength)
        return strongest

    def remaining(self) -> dict[str, float]:
        """What is left to do, by curve."""
        info: Mapping[str, Any] = self.episode.info
        return {name: float(info[name][0]) for name in self.remaining_curves if name in info}

    def progress(self) -> str:
        """What is left to do, in words."""
        return ", ".join(f"{name} {value:.3g}" for name, value in self.remaining().items())

    def handles(self) -> Mapping[str, Handle]:
        """What a hand can drag, by name; the same names from start to end."""
        return {}

    def kick(self) -> None:
        """Displace the object, in worlds that have one."""
        raise ValueError("there is nothing to kick in this world")

    def conflict(self) -> str:
        """What opposes what, in words, while it explores."""
        meeting, arrows = self.episode.meeting, self.arrows()
        opponent = int(meeting.opponent[0])
        dominant = arrows[int(meeting.dominant[0])].label
        if opponent < 0 or meeting.goals_in_conflict(0) is None:
            return f"{dominant}, until it gets on"
        return f"{dominant} ↔ {arrows[opponent].label}"

    def headline(self) -> str:
        """What happens, in a few words."""
        if self.episode.succeeded:
            return "Arrived"
        if self.episode.ended:
            collided = self.episode.info.get("collision", [False])[0]
            return "Collision" if collided else "Out of time"

        meeting = self.episode.meeting
        if bool(meeting.exploring[0]):
            return f"Exploring: {self.conflict()}"
        return f"Descending: {self.arrows()[int(meeting.dominant[0])].label}"

    def labelled(self) -> set[int]:
        """Which gradients have their words: where there are many, the two that are compared."""
        meeting = self.episode.meeting
        if len(meeting.paths) <= _FEW:
            return set(range(len(meeting.paths)))
        return {int(meeting.dominant[0]), int(meeting.opponent[0])}

    def add_grips(self, ask: Request) -> None:
        """Add what a hand takes hold of.

        Args:
            ask: Has something done between two steps.
        """
        for name, handle in self.handles().items():
            grip = self.server.scene.add_transform_controls(
                f"/grip/{name}",
                scale=self.handle_size,
                active_axes=handle.axes,
                disable_rotations=True,
                depth_test=False,
                opacity=0.7,
            )
            self._grips[name] = grip
            self._listen(name, grip, ask)
        self._place_grips()

    def _listen(self, name: str, grip: viser.TransformControlsHandle, ask: Request) -> None:
        """While a hand holds it, it stays in the hand; let go, it moves what it belongs to."""

        @grip.on_update
        def _(event: Any) -> None:
            if event.phase != "end":
                self._dragged.add(name)
                return
            ask(lambda: self._let_go(name))

    def _let_go(self, name: str) -> None:
        """Put what a handle belongs to where the handle is; else the handle goes back."""
        try:
            self.handles()[name].move(np.array(self._grips[name].position))
        finally:
            self._dragged.discard(name)
            self._place_grips()

    def _place_grips(self) -> None:
        """Put each handle where it belongs, unless it is being dragged."""
        handles = self.handles() if self._grips else {}
        for name, grip in self._grips.items():
            if name in handles and name not in self._dragged:
                grip.position = handles[name].where()
