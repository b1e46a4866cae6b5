"""Meta-World: a Sawyer's hand reaches a place, presses a button and closes a drawer.

The world is that of Meta-World (MIT), which `make worlds` puts into a folder of its own. By hand,
in this folder:

    pip install 'aicon-torch[compare]' metaworld==3.1.1 mujoco==3.10.0
    aicon compare --task meta_world:TASK --conditions reach --policies aicon steepest

The graph is that of hands.py; meta_world_puck.py has what fingers take. An episode counts as solved
where the world says so at its last step, which is stricter than the benchmark's own count, at any
step.
"""

from typing import Any

import numpy as np
from gymnasium.spaces import Box, Space
from hands import PRESETS, Hand, Options, policy_options, reach_policy
from others import World, needed, readings, world_task

from aicon_torch import Policy

# --- the world

STEP, HORIZON = 0.0125, 500  # s; steps, the benchmark's
AT_ONCE = 4  # of these steps the policy decides about
STRIDE = 0.01  # m, a step
LAG = 0.045  # s, with which the hand's velocity follows
TIP = np.array([0.0, 0.0, -0.045])  # m, from what the world calls the hand
HAND, THING, BEFORE, GOAL = slice(0, 3), slice(4, 7), 18, slice(36, 39)  # of what it tells


class MetaWorld(World):
    """The world, whose episodes last to the end.

    What moves is read where it comes to rest, x + τ v: by dv/dt = (a − v)/τ that place follows at
    once what the hand is told, d(x + τ v)/dt = a. From there the hand is told how far to go.

    Args:
        task: What the world calls it, such as "reach".
        render_mode: None, or "rgb_array".
    """

    action_space: Space[Any] = Box(-1.0, 1.0, (3,))
    readings: tuple[str, ...] = ("z_hand", "z_goal")
    metadata = {"render_modes": ["rgb_array"], "render_fps": 20}

    def __init__(self, task: str, render_mode: str | None = None) -> None:
        worlds = needed("metaworld.env_dict", "metaworld").ALL_V3_ENVIRONMENTS_GOAL_OBSERVABLE
        self.world = worlds[f"{task}-v3-goal-observable"](seed=0, render_mode=render_mode)
        self.world._freeze_rand_vec, self.world.seeded_rand_vec = False, True
        self.render_mode = render_mode
        self.observation_space = readings(dict.fromkeys(self.readings, 3))

    def reset(self, *, seed: int | None = None, options: Any = None) -> Any:
        """Place things and goal."""
        super().reset(seed=seed)
        if seed is not None:
            self.world.seed(seed)
        self.state = self.world.reset()[0]
        return self._seen(False)

    def step(self, action: Any) -> Any:
        """Move."""
        # It adds what it is told to what it was told before, however far the hand is behind.
        last = self.world.data.mocap_pos[0]
        way = self._way(action) + (self._at_rest(HAND) - last) / (AT_ONCE * STRIDE)
        for _ in range(AT_ONCE):
            sent = np.append(way, self._effort(action)).clip(-1.0, 1.0)
            self.state, _, _, ends, told = self.world.step(sent.astype(np.float32))
        observation, info = self._seen(ends and told["success"])
        return observation, 0.0, False, ends, info

    def _way(self, action: Any) -> Any:
        """How far the hand is told to go."""
        return action

    def _effort(self, action: Any) -> float:
        """Of the fingers, 1 to close: they stay so."""
        return 1.0

    def _read(self, tip: Any, goal: Any) -> Any:
        """What the policy reads, and what is to be at the goal."""
        return {"z_hand": tip, "z_goal": goal}, self.state[HAND] + TIP

    def _at_rest(self, part: slice) -> Any:
        """Where a part of what the world tells comes to rest, m."""
        before = self.state[part.start + BEFORE : part.stop + BEFORE]
        return self.state[part] + LAG * (self.state[part] - before) / STEP

    def _seen(self, success: bool) -> Any:
        tip, goal = self._at_rest(HAND) + TIP, self.state[GOAL]
        observation, placed = self._read(tip, goal)

        # What counts is where it is at the end.
        distance = float(np.linalg.norm(placed - goal))
        info = {"position": tip[:2], "distance": distance, "collision": False}
        return observation, info | {"is_success": bool(success)}


# --- the policy

SAWYER = Hand(time_step=AT_ONCE * STEP, stride=AT_ONCE * STRIDE)


def build(options: Options) -> Policy:
    """The graph of a hand that reaches: a button or drawer on the way to the goal gives way."""
    return reach_policy(SAWYER, options)


TASK = world_task(
    __name__,
    MetaWorld,
    ("reach", "coffee-button", "drawer-close"),
    PRESETS,
    time_step=SAWYER.time_step,
    horizon=HORIZON // AT_ONCE,
    policy_options=policy_options,
)
