"""The observation and action spaces of the pushT task, and the conversions at that border."""

import math
from typing import Any, Literal, cast, get_args

import numpy as np
from gymnasium import spaces
from numpy.typing import ArrayLike, NDArray

from aicon_envs.pusht.geometry import Point
from aicon_envs.pusht.simulation import SIZE
from aicon_envs.pusht.variant import DEFAULT_SPEED, ActionMode

ObsType = Literal["environment_state_agent_pos", "state", "pixels", "pixels_agent_pos"]
Observation = Any  # an array or a dictionary of arrays, by obs_type
Action = NDArray[np.float32]

KEYPOINTS, AGENT, PIXELS, GOAL = "environment_state", "agent_pos", "pixels", "goal_pose"
"""Keys of the dictionary observations."""

Boxes = dict[str, spaces.Space[Any]]

_FULL_TURN = 2.0 * math.pi


def observation_space(
    obs_type: ObsType, num_keypoints: int, observe_goal: bool, height: int, width: int
) -> spaces.Space[Observation]:
    """Return the space of one observation.

    Raises:
        ValueError: If `obs_type` is unknown or has no room for the goal; the message lists the valid values.
    """
    if obs_type not in get_args(ObsType):
        raise ValueError(f"obs_type must be one of {', '.join(get_args(ObsType))}, got {obs_type!r}")
    agent: Boxes = {AGENT: _box([0.0, 0.0], [SIZE, SIZE])}
    pixels: Boxes = {PIXELS: spaces.Box(0, 255, (height, width, 3), np.uint8)}
    goal: Boxes = {GOAL: _box([0.0, 0.0, -_FULL_TURN], [SIZE, SIZE, _FULL_TURN])} if observe_goal else {}
    if obs_type == "environment_state_agent_pos":
        keypoints: Boxes = {KEYPOINTS: _box([0.0] * (2 * num_keypoints), [SIZE] * (2 * num_keypoints))}
        return spaces.Dict(keypoints | agent | goal)
    if obs_type == "pixels_agent_pos":
        return spaces.Dict(pixels | agent | goal)
    if observe_goal:
        raise ValueError(
            "observe_goal adds a key to a dictionary: obs_type must be environment_state_agent_pos or "
            f"pixels_agent_pos, got {obs_type!r}"
        )
    return pixels[PIXELS] if obs_type == "pixels" else _box([0.0] * 5, [SIZE] * 4 + [_FULL_TURN])


def action_space(mode: ActionMode, velocity_limit: float | None) -> spaces.Space[Action]:
    """Return the space of the pusher's target, px, or of its velocity, px/s."""
    speed = velocity_limit or DEFAULT_SPEED
    low, high = (0.0, SIZE) if mode == "position" else (-speed, speed)
    return cast("spaces.Space[Action]", spaces.Box(low, high, (2,), np.float32))  # Box forgets its dtype


def check_action(action: ArrayLike) -> Point:
    """Return the action as two floats.

    Raises:
        ValueError: If the action has another shape or is not finite.
    """
    command = np.asarray(action, dtype=np.float64)
    if command.shape != (2,):
        raise ValueError(f"action must be two numbers (x, y), got shape {command.shape}")
    x, y = command.tolist()
    if not (math.isfinite(x) and math.isfinite(y)):
        raise ValueError(f"action must be finite, got {command.tolist()}")
    return x, y


def _box(low: list[float], high: list[float]) -> spaces.Box:
    return spaces.Box(np.array(low), np.array(high), dtype=np.float64)
