"""PointMaze of Gymnasium-Robotics: a ball that is pushed rolls through a maze that it knows.

The world is that of gymnasium-robotics (MIT), whose other worlds want MuJoCo < 4, so `make worlds`
puts it into a folder of its own. By hand, in this folder:

    pip install 'aicon-torch[compare]' gymnasium-robotics==1.4.2 mujoco==3.10.0
    aicon compare --task pointmaze:TASK --policies aicon steepest --episodes 100 --seed 400000

The ball sees where it is, how fast, and the goal; the map stands in the graph as walls. What is set
by hand are the lag and the length of a collision. ogbench_mazes.py has the same graph.
"""

from dataclasses import dataclass
from typing import Any, ClassVar

import gymnasium
import numpy as np
import torch
from gymnasium.spaces import Box
from others import World, needed, readings, world_task
from planner import Planner
from torch import Tensor

from aicon_torch import (
    Actuator,
    Deterministic,
    DirectDescent,
    Foresight,
    Goal,
    Interconnection,
    NullspaceProjection,
    Policy,
    Rehearsal,
    Sensor,
    WorldModel,
)
from aicon_torch.control import ActionLaw
from aicon_torch.parts import ForceServo, Lag, Walls, norm
from aicon_torch.resolution import Exploration, Resolution, SteepestPath, TrapEscape

# --- the world

STEP = 0.01  # s
RADIUS, MASS = 0.1, 4.19  # of the ball, m, of which a cell is 1 long, and kg
LARGEST = 100.0  # force along each axis, N
HORIZONS = {"umaze": 300, "medium": 600, "large": 800}  # steps, the benchmark's
NAMES = {"umaze": "UMaze", "medium": "Medium", "large": "Large"}
MAPS = {"umaze": "U_MAZE", "medium": "MEDIUM_MAZE", "large": "LARGE_MAZE"}


def robotics(module: str = "") -> Any:
    """The package."""
    return needed(f"gymnasium_robotics{module}", "gymnasium-robotics")


class PointMaze(World):
    """The world, which ends where the ball arrives, as the benchmark counts it."""

    observation_space = readings({"z_ball": 2, "v_ball": 2, "z_goal": 2})
    action_space = Box(-1.0, 1.0, (2,), np.float64)
    metadata = {"render_modes": ["rgb_array"], "render_fps": 50}

    def __init__(self, maze: str, render_mode: str | None = None) -> None:
        gymnasium.register_envs(robotics())
        name = f"PointMaze_{NAMES[maze]}-v3"
        self.world = gymnasium.make(name, continuing_task=False, render_mode=render_mode)
        self.render_mode = render_mode

    def reset(self, *, seed: int | None = None, options: Any = None) -> Any:
        """Place ball and goal."""
        super().reset(seed=seed)
        return self._seen(self.world.reset(seed=seed)[0], False)

    def step(self, action: Any) -> Any:
        """Push."""
        state, _, arrives, ends, told = self.world.step(np.asarray(action, np.float64))
        observation, info = self._seen(state, told["success"])
        return observation, 0.0, arrives, ends, info

    def _seen(self, state: Any, success: bool) -> Any:
        ball, velocity = np.split(state["observation"], 2)
        distance = float(np.linalg.norm(ball - state["desired_goal"]))
        info = {"position": ball, "distance": distance, "is_success": success, "collision": False}
        return {"z_ball": ball, "v_ball": velocity, "z_goal": state["desired_goal"]}, info


# --- the policy

ESCAPE = TrapEscape(progress="reach", hold="avoid", along="avoid", onward=True)
RESOLUTION = NullspaceProjection(exploration=Exploration(escape=ESCAPE))


@dataclass(frozen=True)
class Options:
    """What is set by hand."""

    maze: str = "umaze"
    speed: float = 5.0  # m/s, that of the world
    lag: float = 0.1  # in which the servo brings the ball to a velocity, s
    length: float = 0.04  # of the likelihood of a collision, cells
    resolution: Resolution = RESOLUTION
    law: ActionLaw | None = None  # foresight beyond the lag


PRESETS: dict[str, dict[str, Any]] = {
    "aicon": {},
    "without_escape": {"resolution.exploration.escape": TrapEscape()},
    "without_exploration": {"resolution.exploration": None},
    "weighted_sum": {"resolution.projector": "none"},
    "without_foresight": {"law": DirectDescent()},
    "steepest": {"resolution": SteepestPath()},
}


def build(options: Options) -> Policy:
    """The ball: a servo pushes it, and it follows with a lag."""
    servo, lag = ForceServo(MASS, options.lag, LARGEST), Lag(options.lag)

    def ahead(z_ball: Tensor, v_ball: Tensor, a: Tensor, dt: Tensor) -> Tensor:
        return z_ball + lag.displacement(a, v_ball, dt)

    def push(a: Tensor, v_ball: Tensor) -> Tensor:
        return servo(a, v_ball) / servo.largest

    ball = Actuator(2, "m/s", limit=options.speed, command=push)
    model = maze_model(ball, Interconnection.of(ahead), walls_of(options), STEP)
    return Policy(model, options.resolution, options.law or Foresight(horizon=2 * options.lag))


@dataclass
class Rehearsed:
    """The policy, rehearsed where it begins to explore: see aicon_torch.Rehearsal."""

    maze: str = "umaze"
    enough: ClassVar[float] = 0.45  # how near to the goal it has arrived, cells

    def __post_init__(self) -> None:
        """Build it."""

        def to_go(seen: Any) -> Tensor:
            return norm(seen["z_ball"] - seen["z_goal"])

        policy = self.policy().compile()
        self.predict = Rehearsal(policy, self.imagine, to_go, self.enough).predict

    def policy(self) -> Policy:
        """What is rehearsed."""
        return build(Options(self.maze))

    def imagine(self, seen: Any, memory: Any) -> Any:
        """What is read after a step without a contact."""
        lag, dt = Lag(Options().lag), torch.tensor(STEP)
        moved = lag.displacement(memory["a"], seen["v_ball"], dt)
        v_ball = lag.velocity(memory["a"], seen["v_ball"], dt)
        return seen | {"z_ball": seen["z_ball"] + moved, "v_ball": v_ball}


def map_of(maze: str) -> Any:
    """The rows of a maze, north first, with a 1 where a wall is."""
    return getattr(robotics(".envs.maze.maps"), MAPS[maze])


def walls_of(options: Options) -> Goal:
    """To keep clear of the walls."""
    return keep_clear(map_of(options.maze), RADIUS, options.length)


def keep_clear(grid: Any, radius: float, length: float) -> Goal:
    """To keep clear of a maze whose rows hold a 1 where a wall is, and whose cells are 1 long.

    Args:
        grid: The maze, north first.
        radius: Of the ball, cells.
        length: Of the likelihood of a collision, cells.
    """
    rows = ["".join("#" if cell == 1 else " " for cell in row) for row in grid]
    walls = Walls.from_grid(rows, radius=radius)
    return Goal("avoid", Interconnection(walls.collision_likelihood(length), ["p_ball"]))


def maze_model(ball: Actuator, ahead: Interconnection, avoid: Goal, dt: float) -> WorldModel:
    """The graph of mazes: two goals meet at the place where an action leads.

    Args:
        ball: What moves the ball.
        ahead: Where the ball will be, of ``a``, ``dt`` and what is read.
        avoid: To keep clear of the walls.
        dt: Time step, s.
    """

    def far(p_ball: Tensor, z_goal: Tensor) -> Tensor:
        return norm(p_ball - z_goal)

    return WorldModel(
        sensors={name: Sensor(2, "SI") for name in sorted({"z_goal", *ahead.inputs} - {"a", "dt"})},
        actuators={"a": ball},
        estimators=[Deterministic("p_ball", ahead)],
        goals=[Goal("reach", far), avoid],
        dt=dt,
        dtype=torch.float64,
    )


# --- the opponent


@dataclass
class Planned:
    """A planner that sees the map; the ball is pushed as the policy pushes it."""

    maze: str = "umaze"

    def __post_init__(self) -> None:
        """Read the map."""
        self.options = Options(self.maze)
        self.servo = ForceServo(MASS, self.options.lag, LARGEST)
        self.predict = Planner(map_of(self.maze), RADIUS, self.toward).predict

    def toward(self, place: Any, seen: Any) -> Any:
        """The action that leads to a place."""
        speed = self.options.speed
        wanted = (place - seen["z_ball"]) / self.options.lag
        wanted = wanted * speed / max(speed, float(np.linalg.norm(wanted)))
        force = self.servo(torch.from_numpy(wanted), torch.from_numpy(seen["v_ball"]))
        return (force / self.servo.largest).numpy()


# --- the task


def policy_options(condition: str) -> dict[str, Any]:
    """The map."""
    return {"maze": condition}


TASK = world_task(
    __name__,
    PointMaze,
    HORIZONS,
    PRESETS,
    time_step=STEP,
    horizon=max(HORIZONS.values()),
    maps=("maze",),
    policy_options=policy_options,
    agents={"rehearsed": f"{__name__}:Rehearsed", "planner": f"{__name__}:Planned"},
)
