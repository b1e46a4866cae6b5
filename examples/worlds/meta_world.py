"""Meta-World: a Sawyer's hand reaches a place.

The world is that of Meta-World (MIT), which `make worlds` puts into a folder of its own. By hand,
in this folder:

    pip install 'aicon-torch[compare]' metaworld==3.1.1 mujoco==3.10.0
    aicon compare --task meta_world:TASK --policies aicon steepest

The graph is that of hands.py; meta_world_puck.py has what the gripper takes. An episode counts as
solved where the world says so at its last step, which is stricter than the benchmark's own count,
at any step.
"""

from importlib import import_module
from typing import Any

import gymnasium
import numpy as np
from gymnasium.error import DependencyNotInstalled
from gymnasium.spaces import Box, Dict, Space
from hands import PRESETS, Hand, Options, hand_task, reach_policy

from aicon_torch import Policy

# --- the world

STEP, HORIZON = 0.0125, 500  # s; steps, the benchmark's
STRIDE, LAG = 0.01, 0.045  # m a step; s, with which the hand's velocity follows
TIP = np.array([0.0, 0.0, -0.045])  # m, from what the world calls the hand


class MetaWorld(gymnasium.Env[Any, Any]):
    """The world, whose episodes last to the end.

    Args:
        task: What the world calls it, such as "reach".
        render_mode: None, or "rgb_array".
    """

    action_space: Space[Any] = Box(-1.0, 1.0, (3,))
    observation_space = Dict(
        {name: Box(-np.inf, np.inf, (3,), np.float64) for name in ("z_hand", "v_hand", "z_goal")}
    )
    metadata = {"render_modes": ["rgb_array"], "render_fps": 80}

    def __init__(self, task: str, render_mode: str | None = None) -> None:
        try:
            worlds = import_module("metaworld.env_dict").ALL_V3_ENVIRONMENTS_GOAL_OBSERVABLE
        except ModuleNotFoundError as error:
            raise DependencyNotInstalled(f"{error}: pip install metaworld") from error
        self.world = worlds[f"{task}-v3-goal-observable"](seed=0, render_mode=render_mode)
        self.world._freeze_rand_vec, self.world.seeded_rand_vec = False, True
        self.render_mode = render_mode

    def reset(self, *, seed: int | None = None, options: Any = None) -> Any:
        """Place things and goal."""
        super().reset(seed=seed)
        if seed is not None:
            self.world.seed(seed)
        return self._seen(self.world.reset()[0], {"success": 0.0}, False)

    def step(self, action: Any) -> Any:
        """Move."""
        state, _, _, ends, told = self.world.step(self._sent(action).astype(np.float32))
        observation, info = self._seen(state, told, ends)
        return observation, 0.0, False, ends, info

    def render(self) -> Any:
        """A picture."""
        return self.world.render()

    def close(self) -> None:
        """Close the world."""
        self.world.close()

    def _sent(self, action: Any) -> Any:
        """What the world is sent: the hand's way, and the fingers' effort, here closed."""
        return np.append(action, 1.0)

    def _read(self, tip: Any, velocity: Any, state: Any) -> Any:
        """What the policy reads, and the distance that is left, m."""
        goal = state[36:]
        observation = {"z_hand": tip, "v_hand": velocity, "z_goal": goal}
        return observation, np.linalg.norm(tip - goal)

    def _seen(self, state: Any, told: Any, ends: bool) -> Any:
        tip, velocity = state[:3] + TIP, (state[:3] - state[18:21]) / STEP
        observation, distance = self._read(tip, velocity, state)

        # What counts is where it is at the end.
        info = {"position": tip[:2], "distance": float(distance), "collision": False}
        return observation, info | {"is_success": bool(ends and told["success"])}


# --- the policy

HAND = Hand(time_step=STEP, stride=STRIDE, radius=0.017, lag=LAG)


def build(options: Options) -> Policy:
    """The graph of a hand that reaches."""
    return reach_policy(HAND, options)


TASK = hand_task(__name__, HAND, HORIZON, PRESETS, MetaWorld)
