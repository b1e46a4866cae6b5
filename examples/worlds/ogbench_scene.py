"""A UR5e opens and closes a drawer and a window, presses buttons and places a cube: OGBench's scene.

The buttons lock and unlock drawer and window. In this folder, with what ogbench_cubes.py needs:

    aicon compare --task ogbench_scene:TASK --policies aicon --conditions task1 task2

The graph is that of picking.py, with two handles and two buttons more. Nothing says in which order.
"""

from dataclasses import replace
from typing import Any

import gymnasium
import numpy as np
import torch
from gymnasium.spaces import Box, Dict
from ogbench_cubes import CONDITIONS, EDGE, HAND, SINGLE, Cubes, ogbench
from picking import PRESETS, Options, build_policy
from torch import Tensor

from aicon_baselines.tasks.side_by_side import side_by_side
from aicon_torch import Deterministic, Goal, Interconnection, Policy, Sensor
from aicon_torch.parts import Button, Gripper, Handle
from aicon_torch.shaping import straight_through

__all__ = ["PRESETS", "TASK", "Options", "build"]

# --- the world

HANDLES = {"_drawer": ((0.0, 1.0, 0.0), 0.16), "_window": ((1.0, 0.0, 0.0), 0.2)}
CLEARANCE = 0.16  # m, above which nothing stands in the way, from a cube or a handle on
DEPTH = 0.15  # m, by which the drawer is open
ASIDE = 0.025  # m, from the cube's place to where it touches the drawer's front no more
DOWN = 0.03  # m, from the top of a button to where the tip has pressed it


class Scene(Cubes):
    """The world; its readings are those of one cube, of both handles and of both buttons."""

    def __init__(self, task: int, render_mode: str | None = None) -> None:
        ogbench("ogbench.manipspace")
        made = gymnasium.make("scene-v0", disable_env_checker=True)
        self.world, self.task, self.render_mode = made.unwrapped, task, render_mode
        self.count, self.names = 1, [""]
        sizes = {"z_tip": 4, "z_contact": 1, "z_jaw": 1, "z_block": 4, "z_goal": 3}
        for name in HANDLES:
            sizes |= {f"z_block{name}": 4, f"z_goal{name}": 3, f"z_on{name}": 1}
            sizes |= {f"z_wanted{name}": 1, f"z_button{name}": 3, f"z_way{name}": 1}
        sizes |= {"z_inside": 1, "z_shut": 3}
        self.observation_space = Dict(
            {name: Box(-np.inf, np.inf, (size,), np.float64) for name, size in sizes.items()}
        )

    def reset(self, *, seed: int | None = None, options: Any = None) -> Any:
        """Place the cube, and the arm; drawer, window and buttons as the task begins."""
        gymnasium.Env.reset(self, seed=seed)
        _, told = self.world.reset(seed=seed, options={"task_id": self.task})
        self.yaws = np.zeros(2)
        self.turns = {name: 0.0 for name in HANDLES}
        goal = self.world.cur_task_info["goal"]
        self.goals = goal["block_xyzs"]
        self.wanted = np.float64(goal["button_states"])
        return self._seen(told, False)

    def _seen(self, told: Any, success: bool) -> Any:
        observation, info = super()._seen(told, success)
        data, world = self.world._data, self.world
        places = {"_drawer": world._drawer_target_site_id, "_window": world._window_target_site_id}
        for number, name in enumerate(HANDLES):
            handle = f"privileged{name.replace('_', '/')}_handle"
            yaw = told[f"{handle}_yaw"][0]
            observation[f"z_block{name}"] = np.append(told[f"{handle}_pos"], EDGE * yaw)
            observation[f"z_goal{name}"] = data.site_xpos[places[name]].copy()
            slide = world._data.joint(f"{name[1:]}_slide").qpos
            observation[f"z_way{name}"] = np.abs(slide).copy()
            observation[f"z_on{name}"] = np.float64([told[f"privileged/button_{number}_state"]])
            observation[f"z_wanted{name}"] = self.wanted[[number]]
            top = data.site_xpos[world._button_site_ids[number]]
            observation[f"z_button{name}"] = top - [0.0, 0.0, DOWN]

        # Where the drawer's handle is when it is shut, and whether the cube belongs in the drawer.
        slide = world._data.joint("drawer_slide").qpos[0]
        shut = observation["z_block_drawer"][:3] + [0.0, slide, 0.0]
        observation["z_shut"] = shut
        is_inside = self.goals[0][1] < shut[1]
        observation["z_inside"] = np.float64([is_inside])
        observation["z_goal"] = self.goals[0] - [0.0, is_inside * ASIDE, 0.0]
        return observation, info


# --- the policy


def build(options: Options) -> Policy:
    """The graph of all that pick and place, with this hand, two handles and two buttons."""
    gripper = Gripper(options.size / 2, widest=HAND.widest, speed=HAND.speed, first=HAND.first)
    button = Button(gripper, 2 * DOWN, options.reach)
    told, wanted, known = {}, [], []
    for name in HANDLES:
        told |= {f"z_goal{name}": Sensor(3, "m"), f"z_button{name}": Sensor(3, "m")}
        told |= {f"z_on{name}": Sensor(1, "1"), f"z_wanted{name}": Sensor(1, "1")}
        pressed_by = [f"z_on{name}", "x_tip", "x_opening", f"z_button{name}"]
        known.append(Deterministic(f"p_free{name}", Interconnection(button, pressed_by)))
        wanted += wishes(name, options)
    handles = {name: Handle(options.step, *way) for name, way in HANDLES.items()}

    told["z_inside"] = Sensor(1, "1")
    read = ["z_inside", "x_object_drawer", "z_goal_drawer", "z_goal"]
    known.append(Deterministic("x_place", Interconnection(place_in_drawer, read)))
    read = ["z_inside", "x_obj_drawer", "z_shut"]
    told["z_shut"] = Sensor(3, "m")
    known.append(Deterministic("p_room", Interconnection(room_in_drawer, read)))
    return build_policy(HAND, options, told, wanted, handles, "_drawer", known)


def place_in_drawer(
    z_inside: Tensor, x_object_drawer: Tensor, z_goal_drawer: Tensor, z_goal: Tensor
) -> Tensor:
    """Where the cube's place is, (*B, 3), m: one in the drawer moves with it."""
    moved = x_object_drawer[..., :3] - z_goal_drawer
    return z_goal + (z_inside * moved).detach()  # stops the gradient: no drawer is moved to a cube


def room_in_drawer(z_inside: Tensor, x_obj_drawer: Tensor, z_shut: Tensor) -> Tensor:
    """How likely the cube's place can be come to, (*B, 1): as far as the drawer is open."""
    share = (x_obj_drawer[..., 1:2] - z_shut[..., 1:2]) / DEPTH
    is_open = straight_through(share.clamp(0.0, 1.0), share)
    return 1 - z_inside * (1 - is_open)


def wishes(name: str, options: Options) -> list[Goal]:
    """What is wanted of a handle and of its button: that each is as it should be, and no hand."""

    def moved(x_obj: Tensor, z_goal: Tensor) -> Tensor:
        way = torch.linalg.vector_norm(x_obj[..., :3] - z_goal, dim=-1)
        return (way - options.tolerance).clamp(min=0.0).square() / 2

    def switched(p_free: Tensor, z_wanted: Tensor) -> Tensor:
        return options.free_hand**2 / 2 * (p_free - z_wanted)[..., 0].square()

    def free_hand(p_grasp: Tensor) -> Tensor:
        return options.free_hand**2 / 2 * p_grasp[..., 0]

    return [
        Goal(f"moved{name}", Interconnection(moved, [f"x_obj{name}", f"z_goal{name}"])),
        Goal(f"switched{name}", Interconnection(switched, [f"p_free{name}", f"z_wanted{name}"])),
        Goal(f"free hand{name}", Interconnection(free_hand, [f"p_grasp{name}"])),
    ]


# --- the task


def make_env(count: int, condition: str, horizon: int, **options: Any) -> Any:
    """The worlds of a batch."""
    task = CONDITIONS.index(condition) + 1
    return side_by_side(lambda: Scene(task, **options), count, horizon)


TASK = replace(
    SINGLE,
    name="ogbench_scene",
    horizon=750,
    make_env=make_env,
    policy_options=lambda condition: {"clearance": CLEARANCE},
    model=__name__,
    agents={},
)
