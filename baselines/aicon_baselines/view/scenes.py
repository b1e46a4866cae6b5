"""The worlds that can be watched, by task."""

from collections.abc import Callable

from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.named import find
from aicon_baselines.tasks import load
from aicon_baselines.view.episode import LiveEpisode
from aicon_baselines.view.scene import Scene
from aicon_baselines.view.server import viser

MakeScene = Callable[[viser.ViserServer, LiveEpisode], Scene]
"""Makes a scene, such as the class of one."""


def check_watchable(task: str) -> None:
    """Refuse a task without a scene.

    Raises:
        ComparisonError: It says where a task names one.
    """
    if not load(task).look.scene:
        raise ComparisonError(f"the task {task!r} has no view: its look names no scene")


def make_scene(server: viser.ViserServer, episode: LiveEpisode) -> Scene:
    """The scene of an episode's task, not yet drawn."""
    check_watchable(episode.name)
    scene: Scene = find(load(episode.name).look.scene)(server, episode)
    return scene
