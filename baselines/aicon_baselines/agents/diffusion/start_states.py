"""Where a demonstration starts."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from aicon_envs.pusht import DEFAULT_GOAL, OBJECTS
from aicon_envs.pusht.geometry import place

_GOAL_SPREAD = (40.0, 40.0, 0.5)  # standard deviations of a pose near the goal: px, px, rad
_PUSHER_RANGE = (50.0, 450.0)  # px
_CLEARANCE = 110.0  # px from the middle of the keypoints, where the pusher cannot touch the object


def reset_options(seed: int, near: float) -> dict[str, Any]:
    """Return the options of an episode's reset: none for the usual start, or a state near the goal.

    Args:
        seed: Seed of the episode.
        near: Share of the episodes that start near the goal.
    """
    rng = np.random.default_rng(seed)
    if rng.random() >= near:
        return {}

    object_pose = np.array(DEFAULT_GOAL) + rng.normal(size=3) * _GOAL_SPREAD
    pusher = _sample_free_position(object_pose, rng)
    return {"reset_to_state": [*pusher.tolist(), *object_pose.tolist()]}


def _sample_free_position(
    object_pose: NDArray[np.float64], rng: np.random.Generator
) -> NDArray[np.float64]:
    """Draw a position (2,) of the pusher, px, where it does not touch the object at this pose."""
    keypoints = place(OBJECTS["T"].keypoints, tuple(object_pose)).reshape(-1, 2)
    middle = keypoints.mean(axis=0)

    while True:
        pusher = rng.uniform(*_PUSHER_RANGE, 2)
        if np.linalg.norm(middle - pusher) > _CLEARANCE:
            return pusher
