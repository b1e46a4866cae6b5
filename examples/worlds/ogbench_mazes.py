"""OGBench's point mazes: medium, large, giant, and one with teleporters, five tasks each.

The world is that of OGBench (MIT), which wants MuJoCo < 4, so `make worlds` puts it into a folder
of its own. By hand, in this folder:

    pip install 'aicon-torch[compare]' ogbench==1.2.2 mujoco==3.10.0
    aicon compare --task ogbench_mazes:TASK --policies aicon steepest --conditions giant_task1

The graph is that of pointmaze.py; here a ball goes where it is told at once, without a lag. Lengths
are in cells of 4 m, so that nothing is set for this world.
"""

from dataclasses import dataclass, field
from typing import Any, ClassVar

import gymnasium
import numpy as np
import pointmaze
from gymnasium.spaces import Box
from others import World, needed, readings, world_task
from planner import Planner
from pointmaze import PRESETS, RESOLUTION, keep_clear, maze_model

from aicon_torch import Actuator, Affine, Foresight, Goal, Policy
from aicon_torch.control import ActionLaw
from aicon_torch.parts import DisplacementCommand
from aicon_torch.resolution import Resolution

# --- the world

STEP, HORIZON = 0.1, 1000  # s; steps, the benchmark's
CELL = 4.0  # m
RADIUS, STRIDE = 0.7 / CELL, 0.2 / CELL  # of the ball, and how far it gets in a step; cells
MAZES = ("medium", "large", "giant", "teleport")
CONDITIONS = tuple(f"{maze}_task{number}" for maze in MAZES for number in range(1, 6))


def make_maze(maze: str, **options: Any) -> Any:
    """OGBench's own environment of a maze."""
    needed("ogbench.locomaze", "ogbench")
    return gymnasium.make(f"pointmaze-{maze}-v0", disable_env_checker=True, **options).unwrapped


class Maze(World):
    """A maze whose lengths are in cells, from its middle.

    Args:
        maze: One of MAZES.
        task: 1 to 5: where the ball and the goal are.
        render_mode: None, or "rgb_array".
    """

    observation_space = readings({"z_ball": 2, "z_goal": 2})
    action_space = Box(-1.0, 1.0, (2,), np.float64)
    metadata = {"render_modes": ["rgb_array"], "render_fps": 10}

    def __init__(self, maze: str, task: int, render_mode: str | None = None) -> None:
        self.world = make_maze(maze)
        self.task, self.render_mode = task, render_mode
        height, width = self.world.maze_map.shape
        self.middle = np.array(self.world.ij_to_xy(((height - 1) / 2, (width - 1) / 2)))

    def reset(self, *, seed: int | None = None, options: Any = None) -> Any:
        """Place ball and goal."""
        super().reset(seed=seed)
        self._draw()
        ball, told = self.world.reset(seed=seed, options={"task_id": self.task})
        self.goal = told["goal"]
        return self._seen(ball, False)

    def step(self, action: Any) -> Any:
        """Move."""
        self._draw()
        ball, _, arrives, _, told = self.world.step(np.asarray(action, np.float64))
        observation, info = self._seen(ball, told["success"] > 0)
        return observation, 0.0, arrives, False, info

    def _draw(self) -> None:
        """Begin numpy's own random numbers anew, which the world draws from, of those of ours."""
        np.random.seed(self.np_random.integers(2**32))  # noqa: NPY002  the world's own generator

    def _seen(self, ball: Any, success: bool) -> Any:
        ball, goal = ((place - self.middle) / CELL for place in (ball, self.goal))
        info = {"position": ball, "distance": float(np.linalg.norm(ball - goal))}
        info |= {"is_success": bool(success), "collision": False}
        return {"z_ball": ball, "z_goal": goal}, info


# --- the policy


@dataclass(frozen=True)
class Options:
    """What is set by hand, in PointMaze."""

    maze: str = "medium"
    length: float = 0.04  # of the likelihood of a collision, cells
    resolution: Resolution = RESOLUTION
    law: ActionLaw = field(default_factory=Foresight)


def build(options: Options) -> Policy:
    """The ball: it goes where it is told."""
    ball = Actuator(2, "cells/s", limit=STRIDE / STEP, command=DisplacementCommand(STRIDE))
    model = maze_model(ball, Affine(z_ball=1.0, a="dt"), walls_of(options), STEP)
    return Policy(model, options.resolution, options.law)


def map_of(maze: str) -> Any:
    """The rows of a maze, north first; a teleporter is a wall, as it may lead anywhere."""
    world = make_maze(maze)
    grid = world.maze_map.copy()
    for cell in (world._teleport_info or {}).get("teleport_in_ijs", ()):
        grid[cell] = 1
    world.close()
    return grid[::-1]


def walls_of(options: Options) -> Goal:
    """To keep clear of the walls."""
    return keep_clear(map_of(options.maze), RADIUS, options.length)


@dataclass
class Rehearsed(pointmaze.Rehearsed):
    """The policy, rehearsed where it begins to explore."""

    maze: str = "medium"
    enough: ClassVar[float] = 1.0 / CELL

    def policy(self) -> Policy:
        """What is rehearsed."""
        return build(Options(self.maze))

    def imagine(self, seen: Any, memory: Any) -> Any:
        """What is read after a step without a contact."""
        return seen | {"z_ball": seen["z_ball"] + STEP * memory["a"]}


# --- the opponent


@dataclass
class Planned:
    """A planner that sees the map."""

    maze: str = "medium"

    def __post_init__(self) -> None:
        """Read the map."""
        self.predict = Planner(map_of(self.maze), RADIUS, self.toward).predict

    def toward(self, place: Any, seen: Any) -> Any:
        """The action that leads to a place."""
        strides = (place - seen["z_ball"]) / STRIDE
        return strides / max(1.0, np.abs(strides).max())


# --- the task


def maze(condition: str, **options: Any) -> Maze:
    """The world of a task in a maze."""
    name, task = condition.split("_task")
    return Maze(name, int(task), **options)


def policy_options(condition: str) -> dict[str, Any]:
    """The map."""
    return {"maze": condition.split("_task")[0]}


TASK = world_task(
    __name__,
    maze,
    CONDITIONS,
    PRESETS,
    time_step=STEP,
    horizon=HORIZON,
    chunk_size=20,
    maps=("maze",),
    policy_options=policy_options,
    agents={"rehearsed": f"{__name__}:Rehearsed", "planner": f"{__name__}:Planned"},
)
