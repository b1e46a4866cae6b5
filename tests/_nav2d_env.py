"""Maps, actions and episodes for the tests of the navigation environment."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from aicon_envs.nav2d import Nav2DEnv

ID = "aicon/Nav2D-v0"
SENSING = ("range", "range_bearing")
SQUARE = [(1.0, -1.0), (2.0, -1.0), (2.0, 1.0), (1.0, 1.0)]
QUIET: Any = {"bearing_noise": 0.0, "range_noise": 0.0, "actuation_noise": 0.0}


def own_map(
    obstacles: Any = (SQUARE,), start: Any = (0.0, 0.0), target: Any = (4.0, 0.0)
) -> dict[str, Any]:
    return {"obstacles": list(obstacles), "start": start, "target": target}


def random_actions(steps: int, *shape: int, seed: int = 0) -> NDArray[np.float32]:
    rng = np.random.default_rng(seed)
    return rng.uniform(-1.0, 1.0, size=(steps, *shape, 2)).astype(np.float32)


def velocity(x: float, y: float) -> NDArray[np.float32]:
    return np.array([x, y], dtype=np.float32)


def rollout(env: Nav2DEnv, actions: NDArray[np.float32], **reset: Any) -> NDArray[np.float64]:
    """Return every number that the environment gave, in order."""
    observation, info = env.reset(**reset)
    record = [*observation.values(), info["position"]]

    for action in actions:
        observation, reward, terminated, truncated, info = env.step(action)
        record += [*observation.values(), info["position"], info["clearance"]]
        record += [reward, terminated, truncated]

    return np.concatenate([np.ravel(value).astype(np.float64) for value in record])
