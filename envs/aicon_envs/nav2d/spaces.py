"""The observation and action spaces of the navigation task, and the checks at that border."""

import math
from typing import Any, Literal, get_args

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from aicon_envs.checks import check_choice
from aicon_envs.nav2d.physics import Physics

Sensing = Literal["range", "range_bearing"]
Observation = dict[str, NDArray[np.float32]]
Action = NDArray[np.float32]

VELOCITY = "a velocity in m/s"
"""What an action is, in words."""


def observation_space(sensing: Sensing, physics: Physics) -> spaces.Space[Observation]:
    """Return the space of one agent's observation.

    Raises:
        ValueError: If `sensing` is unknown; the message lists the valid values.
    """
    check_choice("sensing", sensing, get_args(Sensing))

    boxes: dict[str, spaces.Space[Any]] = {
        "bearing": spaces.Box(-math.pi, math.pi, (1,), np.float32),
        "range": spaces.Box(0.0, physics.max_range, (1,), np.float32),
    }
    if sensing == "range_bearing":
        boxes["obstacle_bearing"] = spaces.Box(-math.pi, math.pi, (1,), np.float32)

    observed: spaces.Space[Any] = spaces.Dict(boxes)  # Gymnasium types it as a space of spaces
    return observed


def action_space(physics: Physics) -> spaces.Space[Action]:
    """Return the space of one agent's velocity command, m/s.

    The box is [-1, 1]² (the range that learning libraries expect) or larger if max_speed is; the
    agent itself limits the command's Euclidean norm to max_speed.
    """
    bound = max(1.0, physics.max_speed)
    return spaces.Box(-bound, bound, (2,), np.float32)
