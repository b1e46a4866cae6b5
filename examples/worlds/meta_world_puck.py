"""Meta-World: a Sawyer pushes a puck to a place, between its fingers, and places one in the air.

In this folder, with what meta_world.py needs:

    aicon compare --task meta_world_puck:TASK --conditions push --policies aicon steepest

The graph is that of aicon_torch.models.picking, as for SO-101 and the UR5e: a puck is as large as a
block. A closed hand that pushes it topples it, as it is as high as wide; the fingers have room for
it, and the world's own reward asks for them.
"""

from typing import Any

from gymnasium.spaces import Box, Dict
from meta_world import AT_ONCE, HORIZON, STEP, STRIDE, THING, MetaWorld
from others import world_task

from aicon_torch import Policy
from aicon_torch.models.picking import PRESETS, Hand, Options, build_policy

# --- the world

CLAWS, PADS, APART = 0.1, 0.012, 3  # m, from claw to claw where it tells 1; m; where it tells it
WIDEST = CLAWS - PADS
EFFORT = 10.0  # of the fingers, where the opening is all wrong


class Puck(MetaWorld):
    """The world, whose fingers are told an opening.

    Args:
        task: "push" or "pick-place".
        render_mode: None, or "rgb_array".
    """

    action_space = Dict({"tip": Box(-1.0, 1.0, (3,)), "jaw": Box(0.0, 1.0, (1,))})
    readings = ("z_tip", "z_block", "z_goal")

    def _way(self, action: Any) -> Any:
        return action["tip"]

    def _effort(self, action: Any) -> float:
        opening = (CLAWS * self.state[APART] - PADS) / WIDEST
        return EFFORT * float(opening - action["jaw"][0])

    def _read(self, tip: Any, goal: Any) -> Any:
        observation = {"z_tip": tip, "z_block": self._at_rest(THING), "z_goal": goal}
        return observation, self.state[THING]


# --- the policy

HAND = Hand(
    time_step=AT_ONCE * STEP,
    steps=(AT_ONCE * STRIDE,) * 3,
    widest=WIDEST,
    first=WIDEST,
    speed=0.3,
    height=0.0,
)


def build(options: Options) -> Policy:
    """The graph of all that pick and place, with this hand."""
    return build_policy(HAND, options)


# --- the task


def policy_options(condition: str) -> dict[str, Any]:
    """Nothing wants a free hand where the place is in the air."""
    return {"free_hand": 0.0} if condition == "pick-place" else {}


TASK = world_task(
    __name__,
    Puck,
    ("push", "pick-place"),
    PRESETS,
    time_step=HAND.time_step,
    horizon=HORIZON // AT_ONCE,
    policy_options=policy_options,
)
