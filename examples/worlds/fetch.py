"""Fetch of Gymnasium-Robotics: a hand reaches a place, and pushes a block to one.

The world is that of gymnasium-robotics (MIT), which wants MuJoCo < 4, so `make worlds` puts it into
a folder of its own. By hand, in this folder:

    pip install 'aicon-torch[compare]' gymnasium-robotics==1.4.2 mujoco==3.10.0
    aicon compare --task fetch:TASK --conditions reach push --policies aicon steepest

The graphs are those of hands.py. An episode counts as solved where the world says so at its last
step.
"""

from importlib import import_module
from typing import Any

import gymnasium
import numpy as np
from gymnasium.error import DependencyNotInstalled
from gymnasium.spaces import Box, Dict
from hands import PRESETS, Hand, Options, push_policy, reach_policy

from aicon_baselines.evaluation.task import Task
from aicon_baselines.tasks.side_by_side import side_by_side
from aicon_torch import Policy

# --- the world

STEP, HORIZON = 0.04, 50  # s; steps, the benchmark's
EDGE = 0.05  # m, of the block


class Fetch(gymnasium.Env[Any, Any]):
    """The world, whose episodes last to the end.

    Args:
        pushes: Whether there is a block.
        render_mode: None, or "rgb_array".
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 25}

    def __init__(self, pushes: bool, render_mode: str | None = None) -> None:
        try:
            gymnasium.register_envs(import_module("gymnasium_robotics"))
        except ModuleNotFoundError as error:
            raise DependencyNotInstalled(f"{error}: pip install gymnasium-robotics") from error
        name = f"Fetch{'Push' if pushes else 'Reach'}-v4"
        self.world = gymnasium.make(name, render_mode=render_mode, disable_env_checker=True)
        self.pushes, self.render_mode = pushes, render_mode

        names = ("z_hand", "v_hand", "z_goal")
        self.observation_space = Dict(
            {name: Box(-np.inf, np.inf, (3,), np.float64) for name in names} | {name: Box(-np.inf, np.inf, (2,), np.float64) for name in (("z_place", "v_obj") if pushes else ())}
        )
        plane, line = Box(-1.0, 1.0, (2,)), Box(-1.0, 1.0, (1,))
        self.action_space = Dict({"a": plane, "lift": line}) if pushes else Box(-1.0, 1.0, (3,))

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

    def render(self) -> Any:
        """A picture."""
        return self.world.render()

    def close(self) -> None:
        """Close the world."""
        self.world.close()

    def _seen(self, state: Any, success: float) -> Any:
        read, goal = state["observation"], state["desired_goal"]
        velocity = read[20:23] if self.pushes else read[5:8]
        observation = {"z_hand": read[:3], "v_hand": velocity / STEP, "z_goal": goal}
        if self.pushes:
            observation["v_obj"] = (read[14:16] + read[20:22]) / STEP
            observation["z_place"] = read[3:5]

        # What counts is where it is at the end.
        distance = float(np.linalg.norm(state["achieved_goal"] - goal))
        info = {"position": read[:2], "distance": distance, "collision": False}
        return observation, info | {"is_success": self.steps >= HORIZON and success > 0}


# --- the policies


HAND = Hand(time_step=STEP, stride=0.033, radius=0.015)


def build(options: Options) -> Policy:
    """The graph of a hand that reaches, or of one that pushes a block."""
    if options.task == "reach":
        return reach_policy(HAND, options)
    return push_policy(HAND, EDGE / 2 * options.shape, options)


# --- the task


def make_env(count: int, condition: str, horizon: int, **options: Any) -> Any:
    """The worlds of a batch."""
    return side_by_side(lambda: Fetch(condition == "push", **options), count, horizon)


def policy_options(condition: str) -> dict[str, Any]:
    """What is to be done."""
    return {"task": condition}


TASK = Task(
    name="fetch",
    time_step=STEP,
    horizon=HORIZON,
    chunk_size=50,
    maps=("table",),
    conditions=("reach", "push"),
    make_env=make_env,
    policy_options=policy_options,
    noiseless=("reach", "push"),
    time_unit="steps",
    model=__name__,
    presets=tuple(PRESETS),
)
