"""The observation and action spaces of the pushT task, and the checks at that border."""

import math
from typing import Any, Literal, get_args

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from aicon_envs.checks import check_choice
from aicon_envs.pusht.simulation import SIZE

ObsType = Literal["environment_state_agent_pos", "state", "pixels", "pixels_agent_pos"]
Observation = Any  # an array or a dictionary of arrays, by obs_type
Action = NDArray[np.float32]

KEYPOINTS, AGENT, PIXELS, GOAL = "environment_state", "agent_pos", "pixels", "goal_pose"
"""Keys of the dictionary observations."""

POSITION = "numbers (x, y)"
"""What an action is, in words."""

_FULL_TURN = 2.0 * math.pi


def observation_space(
    obs_type: ObsType, num_keypoints: int, observe_goal: bool, size: tuple[int, int]
) -> spaces.Space[Observation]:
    """Return the space of one observation.

    Args:
        obs_type: What is observed.
        num_keypoints: Number of keypoints of the object.
        observe_goal: Whether the goal's pose is observed too.
        size: Width and height of pictures.

    Raises:
        ValueError: If `obs_type` is unknown or has no room for the goal; the message lists the
            valid values.
    """
    check_choice("obs_type", obs_type, get_args(ObsType))
    _check_room_for_goal(obs_type, observe_goal)

    width, height = size
    pixels = spaces.Box(0, 255, (height, width, 3), np.uint8)

    # Plain arrays.
    if obs_type == "pixels":
        return pixels
    if obs_type == "state":
        return _box([0.0] * 5, [SIZE] * 4 + [_FULL_TURN])

    # Dictionaries: what is seen of the object, the pusher, and perhaps the goal.
    boxes: dict[str, spaces.Space[Any]] = {}
    if obs_type == "pixels_agent_pos":
        boxes[PIXELS] = pixels
    else:
        boxes[KEYPOINTS] = _box([0.0] * (2 * num_keypoints), [SIZE] * (2 * num_keypoints))

    boxes[AGENT] = _box([0.0, 0.0], [SIZE, SIZE])
    if observe_goal:
        boxes[GOAL] = _box([0.0, 0.0, -_FULL_TURN], [SIZE, SIZE, _FULL_TURN])

    return spaces.Dict(boxes)


def action_space() -> spaces.Space[Action]:
    """Return the space of the pusher's target, px."""
    return spaces.Box(0.0, SIZE, (2,), np.float32)


def _check_room_for_goal(obs_type: ObsType, observe_goal: bool) -> None:
    is_dictionary = obs_type in ("environment_state_agent_pos", "pixels_agent_pos")
    if observe_goal and not is_dictionary:
        raise ValueError(
            "observe_goal adds a key to a dictionary: obs_type must be "
            f"environment_state_agent_pos or pixels_agent_pos, got {obs_type!r}"
        )


def _box(low: list[float], high: list[float]) -> spaces.Box:
    return spaces.Box(np.array(low), np.array(high), dtype=np.float64)
