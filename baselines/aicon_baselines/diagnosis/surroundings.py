"""What lies around the robot in the world of a task, seen from above, for the picture."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from aicon_baselines.evaluation.recording import FloatArray


@dataclass(frozen=True)
class Surroundings:
    """The world of one episode at its end, in the unit of the robot's places.

    Attributes:
        walls: What the robot cannot pass, polygons (k, 2).
        thing: What it pushes, a polygon (k, 2); None where it pushes nothing.
        goal: Where that shall lie, (k, 2).
        target: Where the robot shall be, (2,); None where it shall be nowhere.
        flipped: Whether y points down, as in a picture.
    """

    walls: tuple[FloatArray, ...] = ()
    thing: FloatArray | None = None
    goal: FloatArray | None = None
    target: FloatArray | None = None
    flipped: bool = False


def surroundings(
    task: str, env: Any, observation: Mapping[str, Any], info: Mapping[str, Any]
) -> Surroundings:
    """The surroundings in an environment of one episode.

    Args:
        task: Name of the task.
        env: Its environment, with a single episode.
        observation: What it returned last.
        info: Likewise.

    Returns:
        Nothing around the robot for a task that is not known here.
    """
    look = _LOOKS.get(task)
    return Surroundings() if look is None else look(env, observation, info)


def _navigation(env: Any, observation: Mapping[str, Any], info: Mapping[str, Any]) -> Surroundings:
    walls = tuple(np.asarray(wall, dtype=np.float64) for wall in env.unwrapped.maps[0].obstacles)
    return Surroundings(walls, target=info["target"][0])


def _pusht(env: Any, observation: Mapping[str, Any], info: Mapping[str, Any]) -> Surroundings:
    outline = env.unwrapped.envs[0].unwrapped.object.outline
    thing, goal = _placed(outline, info["block_pose"]), _placed(outline, info["goal_pose"])
    return Surroundings(thing=thing, goal=goal, flipped=True)


def _arm(env: Any, observation: Mapping[str, Any], info: Mapping[str, Any]) -> Surroundings:
    corners = np.asarray(env.unwrapped.envs[0].unwrapped.object.corners, dtype=np.float64)
    thing, goal = _placed(corners, info["object_pose"]), _placed(corners, info["target_pose"])
    return Surroundings(thing=thing, goal=goal)


def _placed(outline: FloatArray, poses: FloatArray) -> FloatArray:
    """An outline at the one pose of a batch."""
    from aicon_envs.pusht.geometry import place  # comes with an extra, as what is pushed does

    return place(outline, poses[0])


def _reach(env: Any, observation: Mapping[str, Any], info: Mapping[str, Any]) -> Surroundings:
    return Surroundings(target=np.asarray(observation["target_position"][0][:2]))


_LOOKS: dict[str, Callable[[Any, Mapping[str, Any], Mapping[str, Any]], Surroundings]] = {
    "nav2d": _navigation,
    "pusht": _pusht,
    "arm_push": _arm,
    "reach": _reach,
}
