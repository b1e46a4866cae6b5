"""SO-101 lifts a block by 10 cm and holds it: the graph of pick and place, whose place is above.

In this folder, with what so101_pick_place.py needs:

    aicon compare --task so101_pick_cube:TASK --policies aicon script --episodes 250

The world is left as it is but for three of its own arguments: the hand points down, as it does in
pick and place, its fingers have pads, and an action of 1 moves it by 2.5 cm. Beyond x = 0.35 m the
arm cannot point down.
"""

from dataclasses import replace
from typing import Any, ClassVar

import numpy as np
import so101_pick_place
from others import worlds_of
from so101_pick_place import PickPlace

from aicon_baselines.evaluation.task import told_nothing

LIFT = 0.12  # m, from where the block lay to where it belongs; the world asks for 0.1
FAR = 0.35  # m, from the base

Options, PRESETS, build = so101_pick_place.Options, so101_pick_place.PRESETS, so101_pick_place.build


class PickCube(PickPlace):
    """The world, in which the block's place is above where it lay.

    Args:
        where: "near", where blocks lie within 0.35 m of the base, or "anywhere".
        render_mode: None, or "rgb_array".
    """

    name = "lerobot_env_so101/SO101PickCube-v0"
    arguments: ClassVar[dict[str, Any]] = {"top_down_ik": True, "jaw_pads": True}

    def __init__(self, where: str = "near", render_mode: str | None = None) -> None:
        super().__init__(render_mode=render_mode)
        self.farthest = FAR if where == "near" else np.inf

    def _begin(self, seed: int | None) -> Any:
        state = super()._begin(seed)
        while state["environment_state"][0] > self.farthest:
            state = super()._begin(None)  # the next that the world draws
        self.place = np.float64(state["environment_state"]) + np.array([0.0, 0.0, LIFT])
        return state

    def _places(self, state: Any) -> Any:
        return np.float64(state["environment_state"]), self.place


CONDITIONS = ("near", "anywhere")
TASK = replace(
    so101_pick_place.TASK,
    name="so101_pick_cube",
    horizon=100,
    conditions=CONDITIONS,
    noiseless=CONDITIONS,
    make_env=worlds_of(PickCube),
    policy_options=told_nothing,
    model=__name__,
    lesson=replace(so101_pick_place.LESSON, words="Lift the block."),
)
