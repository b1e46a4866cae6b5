"""The live view: a page that shows an episode while it happens, and lets its reader interfere."""

import threading
import time
from collections.abc import Callable
from functools import partial
from queue import Empty, SimpleQueue
from typing import Any

from aicon_baselines.view.episode import LiveEpisode
from aicon_baselines.view.opening import MakeScene, make_scene
from aicon_baselines.view.panel import Panel
from aicon_baselines.view.server import PageServer
from aicon_torch import AiconError

_PICTURES_PER_SECOND = 15.0
_PANELS_PER_SECOND = 4.0
_REST = 0.01  # s between two looks at what is to do
_LAG = 0.2  # s that it catches up with, where drawing took long


class LiveView:
    """An episode in the browser.

    The server has threads of its own. What a reader asks for is put into a queue and done between
    two steps, in the thread that calls :meth:`run`.

    The policy is compiled in the background, so that the control loop keeps its rate; what the
    pictures need is read off its memory, as often as there is a picture.

    Args:
        episode: The episode, started.
        server: The server of the page, as :func:`serve` starts one; closed with the view.
        paused: Whether it waits for its reader to begin.
        scene: What draws the world; by default the scene of the task.
        compiles: Whether the policy is compiled.
        loops: Whether it goes on with the next seed where an episode has ended.

    Attributes:
        running: Whether it steps by itself.
        speed: How many times as fast as real time it steps.
        taken: Number of steps since the page was opened.
    """

    def __init__(
        self,
        episode: LiveEpisode,
        server: PageServer,
        *,
        paused: bool = False,
        scene: MakeScene = make_scene,
        compiles: bool = True,
        loops: bool = False,
    ) -> None:
        self.episode, self._loops = episode, loops
        self.running, self.speed, self.taken = not paused, 1.0, 0
        self._requests: SimpleQueue[Callable[[], object]] = SimpleQueue()
        self._stopped = threading.Event()
        self._note = ""

        self._server = server
        self.scene = scene(server, episode)
        self._panel = Panel(server, self)
        self.scene.start()
        self.scene.add_grips(self.ask)
        self._show_all()
        if compiles:
            episode.compile()

    @property
    def port(self) -> int:
        """Port of the page."""
        return self._server.get_port()

    def run(self) -> None:
        """Step and draw until :meth:`stop` is called, in real time at speed 1."""
        due = drawn = shown = time.monotonic()

        while not self._stopped.is_set():
            asked = self._do_what_was_asked()
            now = time.monotonic()
            stepped = self.running and now >= due
            if stepped:
                self._advance()
                # What drawing took is caught up with; where it is too slow for the speed, not more.
                due = max(due + self.episode.time_step / self.speed, now - _LAG)

            # Pictures and words, only as often as an eye can follow.
            if asked or (stepped and now >= drawn + 1.0 / _PICTURES_PER_SECOND):
                self._draw(stepped)
                drawn = now
            if asked or (stepped and now >= shown + 1.0 / _PANELS_PER_SECOND) or self._just_ended:
                self._show_all()
                shown = now
            self._stopped.wait(min(max(due - now, 0.0), _REST) if self.running else _REST)

    def stop(self) -> None:
        """Let :meth:`run` return."""
        self._stopped.set()

    def close(self) -> None:
        """End the server and the environment."""
        self._server.stop()
        self.episode.close()

    @property
    def _just_ended(self) -> bool:
        return self.running and self.episode.ended and not self._loops

    def ask(self, request: Callable[..., object], *arguments: Any) -> None:
        """Have something done between two steps; it may be asked for in any thread."""
        self._requests.put(partial(request, *arguments))

    def play(self) -> None:
        """Go on by itself, or from the start again after the end."""
        if self.episode.ended and not self.running:
            self.reset(self.episode.seed)
        self.running = True

    def pause(self) -> None:
        """Rest."""
        self.running = False

    def step_once(self) -> None:
        """Go on by one step, and rest."""
        self.running = False
        self._advance()
        self._panel.add_moment()

    def reset(self, seed: int) -> None:
        """Start the episode of a seed."""
        self.episode.start(seed)
        self.scene.start()
        self._panel.clear()

    def _do_what_was_asked(self) -> bool:
        """Do it; return whether there was anything."""
        asked = False
        while True:
            try:
                request = self._requests.get_nowait()
            except Empty:
                return asked

            # What the world or the policy refuses is told, and nothing changes.
            asked, self._note = True, ""
            try:
                request()
            except (ValueError, AiconError) as error:
                self._note = str(error)

    def _advance(self) -> None:
        """Go on by one step; after the last one, rest or go on with the next seed."""
        if self.episode.ended and self._loops:
            self.reset(self.episode.seed + 1)
        elif self.episode.ended:
            self.running = False
            return
        self.episode.step()
        self.taken += 1

    def _draw(self, stepped: bool) -> None:
        """Draw the world; after a step its numbers become part of the curves."""
        self.scene.draw()
        if stepped:
            self._panel.add_moment()

    def _show_all(self) -> None:
        """Bring picture, words and curves to the present."""
        if self._just_ended:
            self.running = False
        self._panel.show_running(self.running)
        self._panel.show(self._note)
        self.scene.draw()
