"""What lies around the robot in each task, seen from above, by name.

A name with a dot, such as "wall.0", is of something that no legend explains.
"""

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from aicon_baselines.named import find
from aicon_baselines.palette import GOAL, OBJECT, OBSTACLE, OUTLINE, TARGET
from aicon_baselines.tasks import load
from aicon_baselines.worlds.shape import FloatArray, Shape, star

ARRIVAL = 0.2
"""How near navigation's robot has to come to its target, m."""

GOAL_TINT = 0.25
"""Opacity of where an object shall lie."""


def navigation(walls: Iterable[ArrayLike], target: ArrayLike) -> dict[str, Shape]:
    """Walls (N, 2) that a robot cannot pass, and the target that it looks for, m."""
    shapes = {"target": star(target, 1.3 * ARRIVAL, 7, TARGET)}
    for number, wall in enumerate(walls):
        corners = np.asarray(wall, np.float64)
        shapes[f"wall.{number}"] = Shape(corners, 3, OBSTACLE, edge=OBSTACLE, width=1.0)
    return shapes


def pushing(outline: FloatArray, pose: FloatArray, goal: FloatArray) -> dict[str, Shape]:
    """An object with an outline (N, 2), at its pose (x, y, angle) and where it shall lie."""
    from aicon_envs.pusht.geometry import place  # comes with an extra, as what is pushed does

    there, here = (place(outline, tuple(at.tolist())) for at in (goal, pose))
    return {
        "goal": Shape(there, 1, GOAL, opacity=GOAL_TINT),
        "object": Shape(here, 2, OBJECT, edge=OUTLINE),
        "goal.outline": Shape(there, 4, edge=GOAL, width=2.2),
    }


def surroundings(task: str, env: Any, info: Mapping[str, Any]) -> dict[str, Shape]:
    """The surroundings in an environment of one episode; none for a task that names none.

    Args:
        task: Name of the task, whose look names one of the functions below, or its own.
        env: Its environment, a vector of one.
        info: What it told last of the episode.
    """
    source = load(task).look.surroundings
    if not source:
        return {}
    shapes: dict[str, Shape] = find(source)(env, info)
    return shapes


def around_navigation(env: Any, info: Mapping[str, Any]) -> dict[str, Shape]:
    """The walls and the target of navigation."""
    return navigation(env.unwrapped.maps[0].obstacles, info["target"])


def around_pushing(env: Any, info: Mapping[str, Any]) -> dict[str, Shape]:
    """The object of pushT, and where it shall lie."""
    outline = env.unwrapped.envs[0].unwrapped.object.outline
    return pushing(outline, info["block_pose"], info["goal_pose"])


def around_an_arm(env: Any, info: Mapping[str, Any]) -> dict[str, Shape]:
    """The object that an arm pushes, and where it shall lie."""
    corners = np.asarray(env.unwrapped.envs[0].unwrapped.object.corners, np.float64)
    return pushing(corners, info["object_pose"], info["target_pose"])


def around_reaching(env: Any, info: Mapping[str, Any]) -> dict[str, Shape]:
    """The target that an arm reaches for."""
    place = env.unwrapped.envs[0].unwrapped.data.mocap_pos[0]
    return {"target": star(place[:2], 0.05, 7, TARGET)}
