"""A UR5e picks cubes up and places them: OGBench's one, two and three, in one file, without phases.

The world is that of OGBench (MIT), which wants MuJoCo < 4, so `make worlds` puts it into a folder
of its own. By hand, in this folder:

    pip install 'aicon-torch[compare]' ogbench==1.2.2 'mujoco<4'
    aicon compare --task ogbench_cubes:SINGLE --policies aicon oracle --conditions task1 task2
    aicon compare --task ogbench_cubes:DOUBLE --policies aicon oracle --conditions task4 task5

The graph is that of aicon_torch.models.picking; the fingers turn here, too. Each cube has a grasp
of its own.
"""

from dataclasses import dataclass
from typing import Any

import gymnasium
import numpy as np
from gymnasium.envs.registration import load_env_creator
from gymnasium.spaces import Box, Dict
from others import World, needed, readings, world_task

from aicon_baselines.evaluation.task import Task
from aicon_torch import Policy
from aicon_torch.models.picking import PRESETS, SIZE, Hand, Options, block_names, build_policy

# --- the world

NAMES = ("single", "double", "triple")
EDGE = SIZE / 2  # m, from a cube's axis to its side: what a turn is told at
GOAL, CUBE, CENTRE = 19, 9, (0.425, 0.0, 0.0)  # where goals begin, how long one is; decimetres


def made(name: str) -> Any:
    """The world of a name, whose actions, with which an episode begins, can be seeded.

    As it is, it makes another space of actions at each look, and none of them is seeded.
    """
    spec = gymnasium.spec(name)
    kind = load_env_creator(spec.entry_point)
    space = Box(-1.0, 1.0, (5,), np.float32)
    return type(kind.__name__, (kind,), {"action_space": space})(**spec.kwargs)


class Cubes(World):
    """The world, whose yaws do not jump and are told as ways at the edge of a cube.

    Args:
        count: How many cubes there are, 1 to 3.
        task: 1 to 5: where the cubes are and where they belong.
        render_mode: None, or "rgb_array".
    """

    action_space = Dict({"tip": Box(-1.0, 1.0, (4,)), "jaw": Box(0.0, 1.0, (1,))})
    metadata = {"render_modes": ["rgb_array"], "render_fps": 20}

    def __init__(self, count: int, task: int, render_mode: str | None = None) -> None:
        self._open(f"cube-{NAMES[count - 1]}-v0", count, task, render_mode)
        self.observation_space = readings(self._sizes())

    def _open(self, name: str, count: int, task: int, render_mode: str | None) -> None:
        """Make the world of a name, in which so many cubes are."""
        needed("ogbench.manipspace", "ogbench")
        self.world, self.task, self.render_mode = made(name), task, render_mode
        self.count, self.names = count, block_names(count)

    def _sizes(self) -> dict[str, int]:
        """How many numbers each reading has."""
        sizes = {"z_tip": 4, "z_contact": 1, "z_jaw": 1}
        for name in self.names:
            sizes |= {f"z_block{name}": 4, f"z_goal{name}": 3}
        return sizes

    def reset(self, *, seed: int | None = None, options: Any = None) -> Any:
        """Place the cubes, and the arm."""
        super().reset(seed=seed)
        _, told = self.world.reset(seed=seed, options={"task_id": self.task})
        self.yaws = np.zeros(1 + self.count)
        self._read_goals(told)
        return self._seen(told, False)

    def _read_goals(self, told: Any) -> None:
        """Where the cubes belong."""
        goals = told["goal"][GOAL:].reshape(self.count, CUBE)
        self.goals = goals[:, :3] / 10 + CENTRE

    def step(self, action: Any) -> Any:
        """Move."""
        closed = self.told["proprio/gripper_opening"]
        close = 1.0 - action["jaw"] - closed
        sent = np.concatenate([action["tip"], close])
        _, _, ends, _, told = self.world.step(sent.clip(-1.0, 1.0))
        observation, info = self._seen(told, told["success"])
        return observation, 0.0, ends, False, info

    def _seen(self, told: Any, success: bool) -> Any:
        self.told = told
        tip = told["proprio/effector_pos"]
        blocks = [told[f"privileged/block_{cube}_pos"] for cube in range(self.count)]
        yaws = [told[f"privileged/block_{cube}_yaw"][0] for cube in range(self.count)]
        turned = np.array([told["proprio/effector_yaw"][0], *yaws])
        self.yaws = np.unwrap(np.stack([self.yaws, turned]), axis=0)[1]

        observation = {
            "z_tip": np.append(tip, EDGE * self.yaws[0]),
            "z_contact": told["proprio/gripper_contact"],
            "z_jaw": told["proprio/gripper_opening"],
        }
        for cube, name in enumerate(self.names):
            observation[f"z_block{name}"] = np.append(blocks[cube], EDGE * self.yaws[1 + cube])
            observation[f"z_goal{name}"] = self.goals[cube]

        distance = float(np.linalg.norm(blocks - self.goals, axis=-1).max())
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
    """The world's own oracle, memoryless, one a row of the batch.

    It moves the one cube that it is told to: the one of the lowest goal that is not met yet.
    """

    def predict(self, observation: Any, state: Any = None, *_: Any, **__: Any) -> Any:
        """The next actions of the oracle."""
        # One oracle serves all rows, as it remembers nothing but where to go in the end.
        oracles = needed("ogbench.manipspace.oracles.markov.cube_markov", "ogbench")
        mover = oracles.CubeMarkovOracle(env=None)
        mover._final_pos, mover._final_yaw = np.array([0.425, 0.0, 0.3]), 0.0
        mover._step, mover._max_step = 0, 10**6

        rows = []
        for row in range(len(observation["z_tip"])):
            seen = {name: reading[row] for name, reading in observation.items()}
            rows.append(mover.select_action(None, _as_told(seen)))
        actions = np.stack(rows)

        # It tells by how much to close; the world is sent an opening.
        jaw = 1.0 - (observation["z_jaw"] + actions[:, 4:]).clip(0.0, 1.0)
        return {"tip": actions[:, :4].astype(np.float32), "jaw": jaw.astype(np.float32)}, state


def _as_told(seen: dict[str, Any]) -> dict[str, Any]:
    """What is seen of one world, in the world's own words, as the oracle reads it."""
    blocks = np.stack([seen[name] for name in sorted(seen) if name.startswith("z_block")])
    goals = np.stack([seen[name] for name in sorted(seen) if name.startswith("z_goal")])

    # Which cube: of those that are further off than the oracle's own tolerance, the lowest goal.
    is_met = np.linalg.norm(blocks[:, :3] - goals, axis=-1) <= 0.02
    cube = int(np.argmin(goals[:, 2] + is_met))
    return {
        "proprio/effector_pos": seen["z_tip"][:3],
        "proprio/effector_yaw": seen["z_tip"][3:] / EDGE,
        "proprio/gripper_opening": seen["z_jaw"],
        "proprio/gripper_contact": seen["z_contact"],
        "privileged/target_block": 0,
        "privileged/block_0_pos": blocks[cube, :3],
        "privileged/block_0_yaw": blocks[cube, 3:] / EDGE,
        "privileged/target_block_pos": goals[cube],
        "privileged/target_block_yaw": np.zeros(1),
    }


# --- the tasks

CONDITIONS = tuple(f"task{number}" for number in range(1, 6))


def _task(count: int, horizon: int) -> Task:
    def world(condition: str, **options: Any) -> Cubes:
        return Cubes(count, CONDITIONS.index(condition) + 1, **options)

    return world_task(
        __name__,
        world,
        CONDITIONS,
        PRESETS,
        name=f"ogbench_cube_{NAMES[count - 1]}",
        time_step=HAND.time_step,
        horizon=horizon,
        policy_options=lambda condition: {"blocks": count} if count > 1 else {},
        agents={"oracle": f"{__name__}:Oracle"},
    )


SINGLE, DOUBLE, TRIPLE = _task(1, 200), _task(2, 500), _task(3, 1000)
