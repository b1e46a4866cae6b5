"""A UR5e moves a drawer and a window, presses buttons and places a cube: the scene of OGBench.

The buttons lock and unlock drawer and window. In this folder, with what ogbench_cubes.py needs:

    aicon compare --task ogbench_scene:TASK --policies aicon --conditions task1 task2

The graph is that of aicon_torch.models.picking, with two handles and two buttons more. Nothing says
in which order.
"""

from dataclasses import replace
from typing import Any

import numpy as np
from ogbench_cubes import CONDITIONS, EDGE, HAND, SINGLE, Cubes
from others import readings, worlds_of
from torch import Tensor

from aicon_torch import Deterministic, Goal, Interconnection, Policy, Sensor
from aicon_torch.models.picking import (
    PRESETS,
    Options,
    Surroundings,
    build_policy,
    free_hand,
    grasp_of,
)
from aicon_torch.parts import Button, Handle
from aicon_torch.parts.planar import norm
from aicon_torch.shaping import straight_through

__all__ = ["PRESETS", "TASK", "Options", "build"]

# --- the world

# Which way they open, and how far, m.
HANDLES = {"_drawer": ((0.0, 1.0, 0.0), 0.16), "_window": ((1.0, 0.0, 0.0), 0.2)}
CLEARANCE = 0.16  # m, above which nothing stands in the way, from a cube or a handle on
ASIDE = 0.035  # m, from the cube's place to where it touches the drawer's front no more
DOWN = 0.03  # m, from the top of a button to where the tip has pressed it


class Scene(Cubes):
    """The world; its readings are those of one cube, of both handles and of both buttons."""

    def __init__(self, task: int, render_mode: str | None = None) -> None:
        self._open("scene-v0", 1, task, render_mode)
        sizes = self._sizes() | {"z_inside": 1, "z_shut": 3}
        for name in HANDLES:
            sizes |= {f"z_block{name}": 4, f"z_goal{name}": 3, f"z_on{name}": 1}
            sizes |= {f"z_wanted{name}": 1, f"z_button{name}": 3, f"z_way{name}": 1}
        self.observation_space = readings(sizes)

    def _read_goals(self, told: Any) -> None:
        """Where the cube belongs, and whether each button is to be on."""
        goal = self.world.cur_task_info["goal"]
        self.goals = goal["block_xyzs"]
        self.wanted = np.float64(goal["button_states"])

    def _seen(self, told: Any, success: bool) -> Any:
        observation, info = super()._seen(told, success)
        for number, name in enumerate(HANDLES):
            observation |= self._handle(name, told) | self._button(number, name)

        # A cube that belongs in the drawer would touch its front where the task puts it.
        shut = observation["z_block_drawer"][:3] - [0.0, observation["z_way_drawer"][0], 0.0]
        is_inside = self.goals[0][1] < shut[1]
        observation |= {"z_shut": shut, "z_inside": np.float64([is_inside])}
        observation["z_goal"] = self.goals[0] - [0.0, is_inside * ASIDE, 0.0]
        return observation, info

    def _handle(self, name: str, told: Any) -> dict[str, Any]:
        """Where a handle is, where it belongs, and how far from its first end."""
        place, yaw = (told[f"privileged/{name[1:]}_handle_{part}"] for part in ("pos", "yaw"))
        data = self.world._data
        return {
            f"z_block{name}": np.append(place, EDGE * yaw),
            f"z_goal{name}": data.site(f"{name[1:]}_handle_center_target").xpos.copy(),
            f"z_way{name}": np.abs(data.joint(f"{name[1:]}_slide").qpos),
        }

    def _button(self, number: int, name: str) -> dict[str, Any]:
        """Whether a button is on, whether it should be, and where the tip has pressed it."""
        top = self.world._data.site(f"btntop_{number}").xpos
        return {
            f"z_on{name}": np.float64([self.world._cur_button_states[number]]),
            f"z_wanted{name}": self.wanted[[number]],
            f"z_button{name}": top - [0.0, 0.0, DOWN],
        }


# --- the policy


def build(options: Options) -> Policy:
    """The graph of all that pick and place, with this hand, two handles and two buttons."""
    button = Button(grasp_of(HAND, options), 2 * DOWN)
    held = [f"x_rel{name}" for name in ("", *HANDLES)]
    sensors = {"z_inside": Sensor(1, "1"), "z_shut": Sensor(3, "m")}
    goals: list[Goal] = []
    known = [
        Deterministic("x_place", place_in_drawer),
        Deterministic("p_room", room_in_drawer),
    ]
    for name in HANDLES:
        sensors |= {f"z_goal{name}": Sensor(3, "m"), f"z_button{name}": Sensor(3, "m")}
        sensors |= {f"z_on{name}": Sensor(1, "1"), f"z_wanted{name}": Sensor(1, "1")}
        read = [f"z_on{name}", "x_tip", "x_opening", f"z_button{name}", *held]
        known.append(Deterministic(f"p_free{name}", Interconnection(button, read)))
        goals += wishes(name, options)

    handles = {name: Handle(options.reach, *way) for name, way in HANDLES.items()}
    around = Surroundings(sensors, goals, known, handles=handles, has_drawer=True)
    return build_policy(HAND, options, around)


def wishes(name: str, options: Options) -> list[Goal]:
    """What is wanted of a handle and of its button: that each is as it should be, and no hand."""

    def moved(x_obj: Tensor, z_goal: Tensor) -> Tensor:
        way = norm(x_obj[..., :3] - z_goal)
        return (way - options.tolerance).clamp(min=0.0).square() / 2

    def switched(p_free: Tensor, z_wanted: Tensor) -> Tensor:
        return options.free_hand**2 / 2 * (p_free - z_wanted)[..., 0].square()

    return [
        Goal(f"moved{name}", Interconnection(moved, [f"x_obj{name}", f"z_goal{name}"])),
        Goal(f"switched{name}", Interconnection(switched, [f"p_free{name}", f"z_wanted{name}"])),
        free_hand(name, options),
    ]


def place_in_drawer(
    z_inside: Tensor, x_object_drawer: Tensor, z_goal_drawer: Tensor, z_goal: Tensor
) -> Tensor:
    """x_place: where the cube belongs, (*B, 3), m; a place in the drawer moves with it."""
    moved = x_object_drawer[..., :3] - z_goal_drawer
    return z_goal + (z_inside * moved).detach()  # stops the gradient: no drawer is moved to a cube


def room_in_drawer(z_inside: Tensor, x_obj_drawer: Tensor, z_shut: Tensor) -> Tensor:
    """p_room: how likely that place can be come to, (*B, 1), as far as the drawer is open."""
    share = (x_obj_drawer[..., 1:2] - z_shut[..., 1:2]) / HANDLES["_drawer"][1]
    is_open = straight_through(share.clamp(0.0, 1.0), share)
    return 1 - z_inside * (1 - is_open)


# --- the task


def scene(condition: str, **options: Any) -> Scene:
    """The world of a task."""
    return Scene(CONDITIONS.index(condition) + 1, **options)


TASK = replace(
    SINGLE,
    name="ogbench_scene",
    horizon=750,
    make_env=worlds_of(scene),
    policy_options=lambda condition: {"clearance": CLEARANCE},
    model=__name__,
    agents={},
)
