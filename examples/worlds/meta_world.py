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
from hands import PRESETS, Hand, Options, push_policy, reach_policy

from aicon_baselines.evaluation.task import Task
from aicon_baselines.tasks.side_by_side import side_by_side
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

        names = ("z_hand", "v_hand", "z_goal")
        self.observation_space = Dict(
            {name: Box(-np.inf, np.inf, (3,), np.float64) for name in names} | {name: Box(-np.inf, np.inf, (2,), np.float64) for name in (("z_place", "v_obj") if self.pushes else ())}
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
            observation["v_obj"] = (state[4:6] - state[22:24]) / STEP
            observation["z_place"] = state[4:6]

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


# --- the task


def make_env(count: int, condition: str, horizon: int, **options: Any) -> Any:
    """The worlds of a batch."""
    return side_by_side(lambda: MetaWorld(condition, **options), count, horizon)


def policy_options(condition: str) -> dict[str, Any]:
    """What is to be done."""
    return {"task": condition}


TASK = Task(
    name="meta_world",
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
