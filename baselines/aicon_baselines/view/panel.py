"""The panel beside the world: what happens in words, the controls, and curves over time."""

import html
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

from aicon_baselines.view.scene import Scene
from aicon_baselines.view.server import viser
from aicon_baselines.view.strips import Strip
from aicon_baselines.view.style import EXPLORING, GOAL, OUTLINE, RESOLVED, Color, to_hex

_SPEEDS = (0.1, 0.25, 0.5, 1.0, 2.0, 5.0, 10.0)


@dataclass(frozen=True)
class Actions:
    """What the controls do; they are called in a thread of the server.

    Attributes:
        toggle: Go on or pause.
        step: Go on by one step, and pause.
        reset: Start the episode of a seed.
        set_speed: How many times as fast as real time.
        weigh: Give a goal a factor.
        resolve_by: Take another resolution.
        kick: Kick the object.
    """

    toggle: Callable[[], None]
    step: Callable[[], None]
    reset: Callable[[int], None]
    set_speed: Callable[[float], None]
    weigh: Callable[[str, float], None]
    resolve_by: Callable[[str], None]
    kick: Callable[[], None]


class Panel:
    """The panel of an episode.

    Args:
        server: The server of the page.
        scene: The world beside it.
        actions: What the controls do.
    """

    def __init__(self, server: viser.ViserServer, scene: Scene, actions: Actions) -> None:
        self._gui, self._scene, self._actions = server.gui, scene, actions
        self._gui.configure_theme(show_logo=False, show_share_button=False, control_width="large")
        self._gui.main_panel.dock_right()
        self._gui.set_panel_label(f"aicon watch {scene.episode.task.name}")

        self._status = self._gui.add_html("")
        self._add_controls()
        self._add_choices()
        with self._gui.add_folder("What you see"):
            self._gui.add_html(_legend(scene.title, scene.legend))
        with self._gui.add_folder("Over time"):
            self._add_strips()

    def show_running(self, running: bool) -> None:
        """Say on the button what it would do now."""
        self._toggle.label = "Pause" if running else "Play"

    def show(self, note: str = "") -> None:
        """Bring words and curves to the present.

        Args:
            note: What else there is to say.
        """
        self._status.content = _status(self._scene, note)
        for strip in (self._strengths, self._cosine, self._costs):
            strip.show()

    def add_moment(self) -> None:
        """Add the present to the curves."""
        episode = self._scene.episode
        meeting = episode.meeting
        self._strengths.add(episode.time, self._scene.strengths())
        self._cosine.add(episode.time, {"cosine": float(meeting.cosine[0])})
        costs = {name: float(cost[0]) for name, cost in episode.trace.costs.items()}
        self._costs.add(episode.time, costs)

    def clear(self) -> None:
        """Begin the curves anew."""
        for strip in (self._strengths, self._cosine, self._costs):
            strip.clear()

    def _add_controls(self) -> None:
        """Pause, step, reset, speed."""
        gui, actions = self._gui, self._actions
        self._toggle = gui.add_button("Pause")
        self._toggle.on_click(lambda _: actions.toggle())
        gui.add_button("Step").on_click(lambda _: actions.step())

        seed = gui.add_number("Seed", self._scene.episode.seed, min=0, step=1)
        reset = gui.add_button("Reset")
        reset.on_click(lambda _: actions.reset(int(seed.value)))

        speeds = tuple(f"{speed:g} × real time" for speed in _SPEEDS)
        speed = gui.add_dropdown("Speed", speeds, initial_value=speeds[_SPEEDS.index(1.0)])
        speed.on_update(lambda _: actions.set_speed(_SPEEDS[speeds.index(speed.value)]))

    def _add_choices(self) -> None:
        """Goals, resolution, and what a hand can do to the world."""
        gui, actions, episode = self._gui, self._actions, self._scene.episode
        with gui.add_folder("Goals"):
            for goal in episode.policy.model.goals:
                box = gui.add_checkbox(goal, True)
                box.on_update(partial(self._weigh, goal))

        names = episode.resolutions
        rule = gui.add_dropdown("In conflict", names, initial_value=names[0])
        rule.on_update(lambda _: actions.resolve_by(rule.value))

        gui.add_markdown(self._scene.hint)
        if self._scene.can_kick:
            gui.add_button("Kick the object").on_click(lambda _: actions.kick())

    def _weigh(self, goal: str, event: viser.GuiEvent[Any]) -> None:
        """Switch a goal on or off."""
        self._actions.weigh(goal, 1.0 if event.target.value else 0.0)

    def _add_strips(self) -> None:
        """Strengths, cosine, costs."""
        goals = self._scene.episode.policy.model.goals
        self._strengths = Strip(self._gui, "strength of the gradients", self._scene.curves)
        self._cosine = Strip(
            self._gui, "cosine of the two that are compared (−1: they oppose)", {"cosine": RESOLVED}
        )
        self._costs = Strip(self._gui, "cost of each goal", dict.fromkeys(goals))


def _status(scene: Scene, note: str) -> str:
    """What happens, as a headline and a line of numbers."""
    episode = scene.episode
    meeting = episode.meeting
    headline, color = _headline(scene)
    numbers = (
        f"{episode.time:.1f} s · {scene.distance_left()} · cosine {float(meeting.cosine[0]):+.2f}"
    )

    lines = [
        f'<div style="padding:0.4em 1em"><div style="font-weight:700;font-size:1.15em;'
        f'color:{to_hex(color)}">{html.escape(headline)}</div>',
        f"<div>{html.escape(numbers)}</div>",
    ]
    if note:
        lines.append(f'<div style="color:#c4122f">{html.escape(note)}</div>')
    return "".join([*lines, "</div>"])


def _headline(scene: Scene) -> tuple[str, Color]:
    """What happens in a few words, and their colour."""
    episode = scene.episode
    meeting = episode.meeting
    if episode.ended:
        if episode.info["is_success"][0]:
            return "Arrived", GOAL
        return ("Collision", OUTLINE) if episode.info["collision"][0] else ("Out of time", OUTLINE)

    if bool(meeting.exploring[0]):
        return f"Exploring: {scene.conflict()}", EXPLORING
    leader = scene.arrows()[int(meeting.leader[0])].label
    return f"Descending: {leader}", RESOLVED


def _legend(title: str, legend: dict[str, Color]) -> str:
    """What the world is, and each colour with its meaning."""
    rows = [
        f'<div style="padding:0.2em 1em 0.6em;font-size:0.88em;line-height:1.45">'
        f'<p style="margin:0 0 0.5em">{html.escape(title)}</p>'
    ]
    for meaning, color in legend.items():
        swatch = (
            f'<span style="display:inline-block;width:0.9em;height:0.9em;border-radius:3px;'
            f'margin-right:0.5em;vertical-align:-0.1em;background:{to_hex(color)}"></span>'
        )
        rows.append(f"<div>{swatch}{html.escape(meaning)}</div>")
    return "".join([*rows, "</div>"])
