"""Opening an episode to look at: the task's environment, its scene, and a policy with gradients."""

import logging
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from aicon_baselines.agents.registry import ModelPolicy, factory
from aicon_baselines.agents.variants import parse_variant
from aicon_baselines.evaluation.config import one_episode
from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.named import find
from aicon_baselines.tasks import load
from aicon_baselines.view.episode import LiveEpisode
from aicon_baselines.view.scene import Scene
from aicon_baselines.view.server import viser

_LOGGER = logging.getLogger(__name__)


def prepare_episode(
    task_name: str, policy: str = "aicon", condition: str | None = None, seed: int = 0
) -> Callable[[], LiveEpisode]:
    """What builds an episode: all names are right, and nothing is built yet.

    The arguments and errors are those of :func:`open_episode`.
    """
    # The names are checked as in a comparison.
    task = load(task_name)
    task, condition = one_episode(task, condition or task.look.condition, seed)
    if condition == "upstream":
        raise ComparisonError(
            "the condition 'upstream' cannot be watched; 'deterministic' is the same world"
        )

    name, options = parse_variant(policy)
    build = factory(task.name, name, **options)
    if not isinstance(build, ModelPolicy):
        raise ComparisonError(
            f"the policy {name!r} has no gradients to show; aicon watch shows policies of the "
            "library, such as aicon, steepest or potential_field"
        )
    build = replace(build, options={**task.look.options, **build.options})

    def start_arguments(seed: int) -> dict[str, Any]:
        return task.reset_arguments([task.episode(seed)])

    def open_it() -> LiveEpisode:
        _LOGGER.info("Building the policy; for an arm, whose shape is fitted, it takes a while.")
        built: Any = build(condition)
        _LOGGER.info("Building the world.")
        env = task.make_env(1, condition, task.horizon, **task.look.options)

        episode = LiveEpisode(task.name, env, built, start_arguments)
        episode.start(seed)
        return episode

    return open_it


def open_episode(
    task_name: str, policy: str = "aicon", condition: str | None = None, seed: int = 0
) -> LiveEpisode:
    """Build an episode of a task, and start it.

    Args:
        task_name: Name of the task.
        policy: Name of the policy, options of it, or both, as in `aicon run`.
        condition: A condition of the task; by default the usual one, or one with more to see.
        seed: Seed of the episode.

    Raises:
        ComparisonError: If a name is unknown, or the policy is none of the library's.
    """
    return prepare_episode(task_name, policy, condition, seed)()


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
