"""A UR5e picks a cube up and places it: OGBench's cube-single, in one file, without phases.

The world is that of OGBench (MIT), which wants MuJoCo < 4, so give it a virtual environment of its
own. In this folder:

    pip install 'aicon-torch[compare]' ogbench==1.2.2 'mujoco<4'
    aicon compare --task ogbench_cube_single:TASK --policies aicon oracle --conditions task1 task2

The graph is that of picking.py; the fingers turn here, too.
"""

from dataclasses import dataclass
from importlib import import_module
from typing import Any

import gymnasium
import numpy as np
from gymnasium.error import DependencyNotInstalled
from gymnasium.spaces import Box, Dict
from picking import PRESETS, SIZE, Hand, Options, build_policy

from aicon_baselines.evaluation.task import Task
from aicon_baselines.tasks.side_by_side import side_by_side
from aicon_torch import Policy

# --- the world

READINGS = {"z_tip": 4, "z_block": 4, "z_goal": 3, "z_contact": 1, "z_jaw": 1}
EDGE = SIZE / 2  # m, from a cube's axis to its side: what a turn is told at
PLACE, CENTRE = slice(19, 22), (0.425, 0.0, 0.0)  # the goal's cube, in decimetres from a centre


def ogbench(name: str) -> Any:
    """A module of the package."""
    try:
        return import_module(name)
    except ModuleNotFoundError as error:
        raise DependencyNotInstalled(f"{error}: pip install ogbench") from error


class Cube(gymnasium.Env[Any, Any]):
    """The world, whose yaws do not jump and are told as ways at the edge of a cube.

    Args:
        task: 1 to 5: where the cube is and where it belongs.
        render_mode: None, or "rgb_array".
    """

    observation_space = Dict(
        {name: Box(-np.inf, np.inf, (size,), np.float64) for name, size in READINGS.items()}
    )
    action_space = Dict({"tip": Box(-1.0, 1.0, (4,)), "jaw": Box(0.0, 1.0, (1,))})
    metadata = {"render_modes": ["rgb_array"], "render_fps": 20}

    def __init__(self, task: int, render_mode: str | None = None) -> None:
        ogbench("ogbench.manipspace")
        made = gymnasium.make("cube-single-v0", disable_env_checker=True)
        self.world, self.task, self.render_mode = made.unwrapped, task, render_mode

    def reset(self, *, seed: int | None = None, options: Any = None) -> Any:
        """Place the cube, and the arm."""
        super().reset(seed=seed)
        _, told = self.world.reset(seed=seed, options={"task_id": self.task})
        self.yaws = np.zeros(2)
        self.goal = told["goal"][PLACE] / 10 + CENTRE
        return self._seen(told, False)

    def step(self, action: Any) -> Any:
        """Move."""
        closed = self.told["proprio/gripper_opening"]
        close = 1.0 - action["jaw"] - closed
        sent = np.concatenate([action["tip"], close])
        _, _, ends, _, told = self.world.step(sent.clip(-1.0, 1.0))
        observation, info = self._seen(told, told["success"])
        return observation, 0.0, ends, False, info

    def render(self) -> Any:
        """A picture."""
        return self.world.render()

    def close(self) -> None:
        """Close the world."""
        self.world.close()

    def _seen(self, told: Any, success: bool) -> Any:
        self.told = told
        tip, block = told["proprio/effector_pos"], told["privileged/block_0_pos"]
        yaws = np.array([told["proprio/effector_yaw"][0], told["privileged/block_0_yaw"][0]])
        self.yaws = np.unwrap(np.stack([self.yaws, yaws]), axis=0)[1]

        observation = {
            "z_tip": np.append(tip, EDGE * self.yaws[0]),
            "z_block": np.append(block, EDGE * self.yaws[1]),
            "z_goal": self.goal,
            "z_contact": told["proprio/gripper_contact"],
            "z_jaw": told["proprio/gripper_opening"],
        }
        distance = float(np.linalg.norm(block - self.goal))
        info = {"position": tip[:2], "distance": distance, "is_success": bool(success)}
        return observation, info | {"collision": False}


# --- the policy

HAND = Hand(
    time_step=0.05,
    steps=(0.025, 0.025, 0.025, 0.067 * EDGE),
    widest=0.085,
    first=0.085,
    speed=0.5,
    height=0.0,
)


def build(options: Options) -> Policy:
    """The graph of all that pick and place, with this hand."""
    return build_policy(HAND, options)


# --- the opponent


@dataclass
class Oracle:
    """The world's own oracle, memoryless, one a row of the batch."""

    def predict(
        self,
        observation: Any,
        state: Any = None,
        episode_start: Any = None,
        deterministic: bool = True,
    ) -> Any:
        """The next actions of the oracle."""
        # One oracle serves all rows, as it remembers nothing but where to go in the end.
        oracle = ogbench("ogbench.manipspace.oracles.markov.cube_markov").CubeMarkovOracle
        mover = oracle(env=None)
        mover._final_pos, mover._final_yaw = np.array([0.425, 0.0, 0.3]), 0.0
        mover._step, mover._max_step = 0, 10**6

        rows = []
        for row in range(len(observation["z_tip"])):
            seen = {name: observation[name][row] for name in READINGS}
            rows.append(mover.select_action(None, _as_told(seen)))
        actions = np.stack(rows)

        # It tells by how much to close; the world is sent an opening.
        jaw = 1.0 - (observation["z_jaw"] + actions[:, 4:]).clip(0.0, 1.0)
        return {"tip": actions[:, :4].astype(np.float32), "jaw": jaw.astype(np.float32)}, state


def _as_told(seen: dict[str, Any]) -> dict[str, Any]:
    """What is seen of one world, in the world's own words, as the oracle reads it."""
    return {
        "proprio/effector_pos": seen["z_tip"][:3],
        "proprio/effector_yaw": seen["z_tip"][3:] / EDGE,
        "proprio/gripper_opening": seen["z_jaw"],
        "proprio/gripper_contact": seen["z_contact"],
        "privileged/target_block": 0,
        "privileged/block_0_pos": seen["z_block"][:3],
        "privileged/block_0_yaw": seen["z_block"][3:] / EDGE,
        "privileged/target_block_pos": seen["z_goal"],
        "privileged/target_block_yaw": np.zeros(1),
    }


# --- the task

CONDITIONS = tuple(f"task{number}" for number in range(1, 6))


def make_env(count: int, condition: str, horizon: int, **options: Any) -> Any:
    """The worlds of a batch."""
    task = CONDITIONS.index(condition) + 1
    return side_by_side(lambda: Cube(task, **options), count, horizon)


TASK = Task(
    name="ogbench_cube_single",
    time_step=0.05,
    horizon=200,
    chunk_size=10,
    maps=("table",),
    conditions=CONDITIONS,
    make_env=make_env,
    noiseless=CONDITIONS,
    time_unit="steps",
    model=__name__,
    presets=tuple(PRESETS),
    agents={"oracle": f"{__name__}:Oracle"},
)
