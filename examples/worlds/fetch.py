"""Fetch of Gymnasium-Robotics: a hand reaches a place, and pushes a block to one.

The world is that of gymnasium-robotics (MIT), which wants MuJoCo < 4, so `make worlds` puts it into
a folder of its own. By hand, in this folder:

    pip install 'aicon-torch[compare]' gymnasium-robotics==1.4.2 mujoco==3.10.0
    aicon compare --task fetch:TASK --conditions reach push --policies aicon steepest

The graph that reaches is that of hands.py, the one that pushes aicon_torch.models.pushing. An
episode counts as solved where the world says so at its last step.
"""

import math
from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Box, Dict
from hands import PRESETS, Hand, Options, policy_options, reach_policy
from others import World, needed, readings, world_task

from aicon_torch import Policy
from aicon_torch.models.pushing import build_policy
from aicon_torch.parts import ContactOptions, RoundObject

# --- the world

STEP, HORIZON = 0.04, 50  # s; steps, the benchmark's
EDGE = 0.05  # m, of the block


class Fetch(World):
    """The world, whose episodes last to the end.

    Args:
        task: "reach" or "push".
        render_mode: None, or "rgb_array".
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 25}

    def __init__(self, task: str, render_mode: str | None = None) -> None:
        gymnasium.register_envs(needed("gymnasium_robotics", "gymnasium-robotics"))
        name = f"Fetch{task.capitalize()}-v4"
        self.world = gymnasium.make(name, render_mode=render_mode, disable_env_checker=True)
        self.pushes, self.render_mode = task == "push", render_mode

        sizes = {"z_hand": 3, "z_goal": 3}
        sizes |= {"z_place": 2, "v_obj": 2} if self.pushes else {}
        self.observation_space = readings(sizes)
        plane, line = Box(-1.0, 1.0, (2,)), Box(-1.0, 1.0, (1,))
        self.action_space = (
            Dict({"a": plane, "lift": line}) if self.pushes else Box(-1.0, 1.0, (3,))
        )

    def reset(self, *, seed: int | None = None, options: Any = None) -> Any:
        """Place block and goal."""
        super().reset(seed=seed)
        self.steps = 0
        return self._seen(self.world.reset(seed=seed)[0], 0.0)

    def step(self, action: Any) -> Any:
        """Move."""
        way = np.concatenate([action["a"], action["lift"]]) if self.pushes else action
        state, _, _, _, told = self.world.step(np.append(way, 0.0).astype(np.float32))
        self.steps += 1
        observation, info = self._seen(state, told["is_success"])
        return observation, 0.0, False, self.steps >= HORIZON, info

    def _seen(self, state: Any, success: float) -> Any:
        read, goal = state["observation"], state["desired_goal"]
        observation = {"z_hand": read[:3], "z_goal": goal}
        if self.pushes:
            from_hand, of_hand = read[14:16], read[20:22]  # how far in a step
            observation |= {"z_place": read[3:5], "v_obj": (from_hand + of_hand) / STEP}

        # What counts is where it is at the end.
        distance = float(np.linalg.norm(state["achieved_goal"] - goal))
        info = {"position": read[:2], "distance": distance, "collision": False}
        return observation, info | {"is_success": self.steps >= HORIZON and success > 0}


# --- the policies

HAND = Hand(time_step=STEP, stride=0.033)  # of 5 cm it goes 3.3, at once
FINGER, RADIUS = 0.015, EDGE / math.sqrt(math.pi)  # m, of a round block as large as this one
FRICTION = 1.0  # between block, table and finger: what MuJoCo assumes


def build(options: Options) -> Policy:
    """The graph of what there is to do."""
    return {"reach": reach, "push": push}[options.task](options)


def reach(options: Options) -> Policy:
    """The graph of a hand that reaches."""
    return reach_policy(HAND, options)


def push(options: Options) -> Policy:
    """The graph of one that pushes a block."""
    block = RoundObject(RADIUS, FINGER, FRICTION, ContactOptions(options.size))
    return build_policy(HAND, block, options)


TASK = world_task(
    __name__,
    Fetch,
    ("reach", "push"),
    PRESETS,
    time_step=STEP,
    horizon=HORIZON,
    policy_options=policy_options,
)
