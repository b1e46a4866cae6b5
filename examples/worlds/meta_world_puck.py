"""Meta-World: a Sawyer takes a puck and pushes it to a place, between its fingers.

In this folder, with what meta_world.py needs:

    aicon compare --task meta_world_puck:TASK --policies aicon steepest

The graph is that of picking.py, as for SO-101 and the UR5e. The puck is 4 cm high and topples where
a closed hand pushes it; the fingers have room for it, and the world's own reward asks for them.
"""

from typing import Any

import numpy as np
from gymnasium.spaces import Box, Dict
from meta_world import HORIZON, LAG, STEP, STRIDE, TIP, MetaWorld
from picking import PRESETS, Hand, Options, build_policy

from aicon_baselines.evaluation.task import Task, told_nothing
from aicon_baselines.tasks.side_by_side import side_by_side
from aicon_torch import Policy

# --- the world

DECIDED = 4  # steps of the world at once
WIDEST = 0.088  # m, between the fingers
EFFORT = 10.0


class Puck(MetaWorld):
    """The world, in which the tip is read where it comes to rest, x + τ v.

    That place follows at once what the hand is told: from dv/dt = (a − v)/τ it is
    d(x + τ v)/dt = a.

    Args:
        task: "push", or "pick-place".
        render_mode: None, or "rgb_array".
    """

    action_space = Dict({"tip": Box(-1.0, 1.0, (3,)), "jaw": Box(0.0, 1.0, (1,))})
    observation_space = Dict(
        {name: Box(-np.inf, np.inf, (3,), np.float64) for name in ("z_tip", "z_block", "z_goal")}
    )

    def step(self, action: Any) -> Any:
        """Move, in as many of the world's steps as the policy decides about at once."""
        told = self.world.data.mocap_pos[0] + TIP
        way = action["tip"] + (self.tip - told) / (DECIDED * STRIDE)
        for _ in range(DECIDED):
            result = super().step({"tip": way, "jaw": action["jaw"]})
        return result

    def _sent(self, action: Any) -> Any:
        effort = (self.opening - action["jaw"]) * EFFORT  # 1 closes the fingers
        return np.append(action["tip"], effort).clip(-1.0, 1.0)

    def _read(self, tip: Any, velocity: Any, state: Any) -> Any:
        puck, goal = state[4:7], state[36:]
        self.opening = (state[3] * 0.1 - 0.012) / WIDEST
        slides = (puck - state[22:25]) / STEP
        self.tip = tip + LAG * velocity
        observation = {"z_tip": self.tip, "z_block": puck + LAG * slides, "z_goal": goal}
        return observation, np.linalg.norm(puck - goal)


# --- the policy

HAND = Hand(
    time_step=DECIDED * STEP, steps=(DECIDED * STRIDE,) * 3, widest=WIDEST, first=WIDEST, speed=0.3, height=0.0
)


def build(options: Options) -> Policy:
    """The graph of all that pick and place, with this hand."""
    return build_policy(HAND, options)


# --- the task

CONDITIONS = ("push", "pick-place")


def make_env(count: int, condition: str, horizon: int, **options: Any) -> Any:
    """The worlds of a batch."""
    return side_by_side(lambda: Puck(condition, **options), count, horizon)


TASK = Task(
    name=__name__,
    time_step=DECIDED * STEP,
    horizon=HORIZON // DECIDED,
    chunk_size=50,
    maps=("table",),
    conditions=CONDITIONS,
    make_env=make_env,
    policy_options=told_nothing,
    noiseless=CONDITIONS,
    time_unit="steps",
    model=__name__,
    presets=tuple(PRESETS),
)
