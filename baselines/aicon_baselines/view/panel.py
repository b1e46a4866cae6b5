"""The panel beside the world: what happens in words, the controls, and curves over time."""

from functools import partial
from typing import TYPE_CHECKING, Any

from aicon_baselines.palette import GOAL, RESOLVED
from aicon_baselines.view.episode import ANYWHERE
from aicon_baselines.view.graph_picture import GraphPicture
from aicon_baselines.view.server import viser
from aicon_baselines.view.status import legend, status
from aicon_baselines.view.strips import Strip

if TYPE_CHECKING:
    from aicon_baselines.view.live import LiveView

_SPEEDS = (0.1, 0.25, 0.5, 1.0, 2.0, 5.0, 10.0)
_HEAVIEST = 3.0  # factor of a goal


class Panel:
    """The panel of an episode.

    Args:
        server: The server of the page.
        view: The view, which does what the controls ask for between two steps.
    """

    def __init__(self, server: viser.ViserServer, view: "LiveView") -> None:
        self._gui, self._view, self._scene = server.gui, view, view.scene
        scene = view.scene
        self._gui.main_panel.dock_right()
        self._gui.set_panel_label(f"aicon watch {scene.episode.name}")

        self._status = self._gui.add_html("")
        self._add_controls()
        self._add_choices()
        with self._gui.add_folder("What you see"):
            self._gui.add_html(legend(scene.title, scene.legend))
        with self._gui.add_folder("Along the graph"):
            self._add_graph()
        with self._gui.add_folder("Over time"):
            self._add_strips()

    def show_running(self, running: bool) -> None:
        """Show the button of what can be done now."""
        self._play.visible, self._pause.visible = not running, running

    def show(self, note: str = "") -> None:
        """Bring words, graph and curves to the present.

        Args:
            note: What else there is to say.
        """
        self._status.content = status(self._scene, note)
        self._graph.content = self._picture.draw(self._scene.episode.trace)
        for strip in self._strips:
            strip.show()

    def add_moment(self) -> None:
        """Add the present to the curves."""
        scene, episode = self._scene, self._scene.episode
        costs = {name: float(cost[0]) for name, cost in episode.trace.costs.items()}
        left = scene.remaining() | {"success": float(episode.succeeded)}
        moments = (scene.strengths(), {"cosine": float(episode.meeting.cosine[0])}, costs, left)
        for strip, values in zip(self._strips, moments, strict=True):
            strip.add(episode.time, values)

    def clear(self) -> None:
        """Begin the curves anew."""
        for strip in self._strips:
            strip.clear()

    def _add_controls(self) -> None:
        """Play or pause, step, reset, speed."""
        gui, view = self._gui, self._view

        # Two buttons in one place: a click means what was to be read when it was made.
        self._play, self._pause = gui.add_button("Play"), gui.add_button("Pause")
        self._play.on_click(lambda _: view.ask(view.play))
        self._pause.on_click(lambda _: view.ask(view.pause))
        gui.add_button("Step").on_click(lambda _: view.ask(view.step_once))

        seed = gui.add_number("Seed", self._scene.episode.seed, min=0, step=1)
        reset = gui.add_button("Reset")
        reset.on_click(lambda _: view.ask(view.reset, int(seed.value)))

        speeds = tuple(f"{speed:g} × real time" for speed in _SPEEDS)
        speed = gui.add_dropdown("Speed", speeds, initial_value=speeds[_SPEEDS.index(1.0)])
        speed.on_update(
            lambda _: view.ask(setattr, view, "speed", _SPEEDS[speeds.index(speed.value)])
        )

    def _add_choices(self) -> None:
        """Goals, resolution, quantity, and what a hand can do to the world."""
        gui, view, episode = self._gui, self._view, self._scene.episode
        with gui.add_folder("Goals"):
            for goal in episode.policy.model.goals:
                slider = gui.add_slider(goal, 0.0, _HEAVIEST, 0.05, 1.0, hint="0: switched off")
                slider.on_update(partial(self._weigh, goal))

        names = episode.resolutions
        rule = gui.add_dropdown("In conflict", names, initial_value=names[0])
        rule.on_update(lambda _: view.ask(episode.resolve_by, rule.value))

        places = (ANYWHERE, *episode.trace.quantities)
        place = gui.add_dropdown("Gradients at", places, initial_value=ANYWHERE)
        place.on_update(lambda _: view.ask(episode.look_at, place.value))

        gui.add_markdown(self._scene.hint)
        if self._scene.can_kick:
            gui.add_button("Kick").on_click(lambda _: view.ask(self._scene.kick))

    def _weigh(self, goal: str, event: viser.GuiEvent[Any]) -> None:
        """Give a goal the weight of its slider."""
        self._view.ask(self._scene.episode.weigh, goal, float(event.target.value))

    def _add_graph(self) -> None:
        """The model, with what comes along its edges."""
        model = self._scene.episode.policy.model
        colors = {goal: self._scene.goal_color(goal) for goal in model.goals}
        self._picture = GraphPicture(model, colors)
        self._graph = self._gui.add_html("")

    def _add_strips(self) -> None:
        """Magnitudes, cosine, costs, and what is left."""
        gui, scene = self._gui, self._scene
        goals = scene.episode.policy.model.goals
        costs = {goal: scene.goal_color(goal) for goal in goals}
        left = {**scene.remaining_curves, "success": GOAL}
        self._strips = (
            Strip(gui, "magnitude of the gradients", scene.strength_curves()),
            Strip(
                gui, "cosine of the two that are compared (−1: they oppose)", {"cosine": RESOLVED}
            ),
            Strip(gui, "cost of each goal", costs),
            Strip(gui, "what is left, and success", left),
        )
