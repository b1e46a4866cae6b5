"""The worlds that can be watched, by task."""

from importlib import import_module

from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.view.episode import LiveEpisode
from aicon_baselines.view.scene import Scene
from aicon_baselines.view.server import viser

_SCENES = {
    "nav2d": ("aicon_baselines.view.nav2d", "NavigationScene"),
    "pusht": ("aicon_baselines.view.pusht", "PushScene"),
}


def check_watchable(task: str) -> None:
    """Refuse a task without a scene.

    Raises:
        ComparisonError: With the tasks that have one.
    """
    if task not in _SCENES:
        raise ComparisonError(
            f"the task {task!r} has no view; tasks with one: {', '.join(_SCENES)}"
        )


def make_scene(server: viser.ViserServer, episode: LiveEpisode) -> Scene:
    """The scene of an episode's task, not yet drawn."""
    check_watchable(episode.task.name)
    module, name = _SCENES[episode.task.name]
    scene: Scene = getattr(import_module(module), name)(server, episode)
    return scene
