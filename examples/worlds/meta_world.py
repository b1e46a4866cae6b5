"""Meta-World: a Sawyer's hand reaches a place, and pushes a puck to one.

The world is that of Meta-World (MIT), which `make worlds` puts into a folder of its own. By hand,
in this folder:

    pip install 'aicon-torch[compare]' metaworld==3.1.1 mujoco==3.10.0
    aicon compare --task meta_world:TASK --conditions reach push --policies aicon steepest

The graphs are those of hands.py. An episode counts as solved where the world says so at its last
step, which is stricter than the benchmark's own count, at any step.
"""

from importlib import import_module
from typing import Any

import gymnasium
import numpy as np
from gymnasium.error import DependencyNotInstalled
from gymnasium.spaces import Box, Dict
from hands import PRESETS, Hand, Options, hand_task, push_policy, reach_policy

from aicon_torch import Policy

# --- the world

STEP, HORIZON = 0.0125, 500  # s; steps, the benchmark's
TIP = np.array([0.0, 0.0, -0.045])  # m, from what the world calls the hand
PUCK = 0.02  # m, its radius


class MetaWorld(gymnasium.Env[Any, Any]):
    """The world, whose episodes last to the end.

    Args:
        task: "reach" or "push".
        render_mode: None, or "rgb_array".
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 80}

    def __init__(self, task: str, render_mode: str | None = None) -> None:
        try:
            worlds = import_module("metaworld.env_dict").ALL_V3_ENVIRONMENTS_GOAL_OBSERVABLE
        except ModuleNotFoundError as error:
            raise DependencyNotInstalled(f"{error}: pip install metaworld") from error
        self.world = worlds[f"{task}-v3-goal-observable"](seed=0, render_mode=render_mode)
        self.world._freeze_rand_vec, self.world.seeded_rand_vec = False, True
        self.pushes, self.render_mode = task == "push", render_mode

        sizes = {"z_hand": 3, "v_hand": 3, "z_goal": 3}
        sizes |= {"z_place": 2, "v_obj": 2} if self.pushes else {}
        self.observation_space = Dict(
            {name: Box(-np.inf, np.inf, (size,), np.float64) for name, size in sizes.items()}
        )
        plane, line = Box(-1.0, 1.0, (2,)), Box(-1.0, 1.0, (1,))
        pushed = Dict({"a": plane, "lift": line})
        self.action_space = pushed if self.pushes else Box(-1.0, 1.0, (3,))

    def reset(self, *, seed: int | None = None, options: Any = None) -> Any:
        """Place puck and goal."""
        super().reset(seed=seed)
        if seed is not None:
            self.world.seed(seed)
        return self._seen(self.world.reset()[0], {"success": 0.0}, False)

    def step(self, action: Any) -> Any:
        """Move, with the fingers closed."""
        way = np.concatenate([action["a"], action["lift"]]) if self.pushes else action
        state, _, _, ends, told = self.world.step(np.append(way, 1.0).astype(np.float32))
        observation, info = self._seen(state, told, ends)
        return observation, 0.0, False, ends, info

    def render(self) -> Any:
        """A picture."""
        return self.world.render()

    def close(self) -> None:
        """Close the world."""
        self.world.close()

    def _seen(self, state: Any, told: Any, ends: bool) -> Any:
        tip, goal = state[:3] + TIP, state[36:]
        velocity = (state[:3] - state[18:21]) / STEP
        observation = {"z_hand": tip, "v_hand": velocity, "z_goal": goal}
        if self.pushes:
            observation["z_place"] = state[4:6]
            observation["v_obj"] = (state[4:6] - state[22:24]) / STEP

        # What counts is where it is at the end.
        placed = state[4:7] if self.pushes else tip
        distance = float(np.linalg.norm(placed - goal))
        info = {"position": tip[:2], "distance": distance, "collision": False}
        return observation, info | {"is_success": bool(ends and told["success"])}


# --- the policies

HAND = Hand(time_step=STEP, stride=0.01, radius=0.017, lag=0.045)


def build(options: Options) -> Policy:
    """The graph of a hand that reaches, or of one that pushes a puck."""
    if options.task == "reach":
        return reach_policy(HAND, options)
    return push_policy(HAND, PUCK, options)


TASK = hand_task(__name__, HAND, HORIZON, PRESETS, MetaWorld)
