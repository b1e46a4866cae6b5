"""The worlds that can be watched, by task."""

from collections.abc import Callable
from importlib import import_module

from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.view.episode import LiveEpisode
from aicon_baselines.view.scene import Scene
from aicon_baselines.view.server import viser

MakeScene = Callable[[viser.ViserServer, LiveEpisode], Scene]
"""Makes a scene, such as the class of one."""

_SCENES = {
    "nav2d": ("aicon_baselines.view.nav2d", "NavigationScene"),
    "pusht": ("aicon_baselines.view.pusht", "PushScene"),
    "arm_push": ("aicon_baselines.view.arm_push", "ArmPushScene"),
    "reach": ("aicon_baselines.view.reach", "ReachScene"),
}

WATCHABLE = tuple(_SCENES)
"""The tasks with a scene."""


def check_watchable(task: str) -> None:
    """Refuse a task without a scene.

    Raises:
        ComparisonError: With the tasks that have one.
    """
    if task not in _SCENES:
        raise ComparisonError(
            f"the task {task!r} has no view; tasks with one: {', '.join(WATCHABLE)}"
        )


def make_scene(server: viser.ViserServer, episode: LiveEpisode) -> Scene:
    """The scene of an episode's task, not yet drawn."""
    check_watchable(episode.name)
    module, name = _SCENES[episode.name]
    scene: Scene = getattr(import_module(module), name)(server, episode)
    return scene
