"""The evaluation task "reach": arms that reach for positions and poses.

A condition names the robot, what counts, where the joints start and what else is different, such as
"ur5_pose_random_fast". The environment's seed is the episode's seed; there is no noise.
"""

import math
from functools import partial
from itertools import product
from typing import Any

from gymnasium.vector import VectorEnv

from aicon_baselines.evaluation.errors import find_known
from aicon_baselines.evaluation.task import Look, Measure, Task
from aicon_baselines.named import Later
from aicon_baselines.tasks.side_by_side import side_by_side
from aicon_envs.reach import ReachEnv

ROBOTS = ("panda", "ur5", "xarm7")

OTHERS = ("kinova", "ur3", "ur10", "z1")
"""Robots that reach for poses alone, as slowly as all, with nothing about."""

_VARIANTS: dict[str, dict[str, Any]] = {
    "": {},
    "_fast": {"speed": 3.0},
    "_ball": {"balls": 1},
    "_moving_ball": {"balls": 1, "ball_speed": 0.2},
    "_five_balls": {"balls": 5, "ball_speed": 0.2},
}
"""What else is different, by the end of the condition's name."""

_ORIENTATIONS = {"position": "free", "axis": "axis", "pose": "full"}
"""What the policy calls the environment's targets."""


def _arguments() -> dict[str, dict[str, Any]]:
    """The arguments of the environment in each condition."""
    by_name: dict[str, dict[str, Any]] = {}
    for robot, target, start in product(ROBOTS, ("pose", "position"), ("home", "random")):
        for ending, different in _VARIANTS.items():
            name = f"{robot}_{target}_{start}{ending}"
            by_name[name] = {"robot": robot, "target": target, "start": start, **different}

    # Five joints reach a position and an approach axis.
    for start in ("home", "random"):
        for robot in OTHERS:
            name = f"{robot}_pose_{start}"
            by_name[name] = {"robot": robot, "target": "pose", "start": start}
        by_name[f"so101_axis_{start}"] = {"robot": "so101", "target": "axis", "start": start}
    return by_name


_ARGUMENTS = _arguments()
_AGENTS = "aicon_baselines.agents.reach"


def _make_env(count: int, condition: str, horizon: int, **options: Any) -> VectorEnv[Any, Any, Any]:
    arguments = find_known("condition", condition, _ARGUMENTS) | options
    return side_by_side(partial(ReachEnv, **arguments), count, horizon)


def _policy_options(condition: str) -> dict[str, Any]:
    """Tell the policy its robot, what counts, how fast it may be, and of balls if there are any."""
    arguments = find_known("condition", condition, _ARGUMENTS)
    env = ReachEnv(**arguments)
    description = env.description()
    balls = {name: description[name] for name in ("balls", "ball_radius")}

    return {
        "robot": description["urdf"],
        "tip": description["tip"],
        "srdf": description["srdf"],
        "orientation": _ORIENTATIONS[env.target],
        "speed": arguments.get("speed", 1.5),
        "dt": description["time_step"],
        **(balls if description["balls"] else {}),
    }


TASK = Task(
    name="reach",
    time_step=0.02,
    horizon=1_000,
    chunk_size=50,
    maps=("free",),
    conditions=tuple(_ARGUMENTS),
    patterns=(
        "{panda,ur5,xarm7}_{pose,position}_{home,random}{,_fast,_ball,_moving_ball,_five_balls}",
        "{kinova,ur3,ur10,z1}_pose_{home,random}",
        "so101_axis_{home,random}",
    ),
    make_env=_make_env,
    policy_options=_policy_options,
    noiseless=tuple(_ARGUMENTS),
    milestones=(250, 500),
    measures=(
        Measure("angle", "median angle at the end", "{:.1f}°", math.degrees(1.0)),
        Measure("limit_margin", "least distance to a joint's stop", "{:.3f} rad", least=True),
        Measure("self_gap", "least gap of the robot to itself", "{:.0f} mm", 1e3, least=True),
        Measure("ball_gap", "least gap to a ball", "{:.0f} mm", 1e3, least=True),
    ),
    model="reach",
    presets=("aicon", "without_escape", "steepest", "potential_field"),
    agents={
        "damped_least_squares": f"{_AGENTS}:DampedLeastSquares",
        "damped_least_squares_places": Later(f"{_AGENTS}:DampedLeastSquares", {"places": True}),
        "mink": f"{_AGENTS}:Mink",
        "mink_places": Later(f"{_AGENTS}:Mink", {"places": True}),
        "pink": f"{_AGENTS}:Pink",
        "pink_places": Later(f"{_AGENTS}:Pink", {"places": True}),
        "placo": f"{_AGENTS}:Placo",
        "placo_places": Later(f"{_AGENTS}:Placo", {"places": True}),
    },
    look=Look(
        scene="aicon_baselines.view.reach:ReachScene",
        surroundings="aicon_baselines.worlds.surroundings:around_reaching",
        condition="panda_pose_home_ball",  # where there is something to keep off
    ),
)
