"""A crowd: a robot crosses a circle, or two streams, of people who move by ORCA.

The people are those of RVO2 (Apache-2.0) in pyrvo, which `make worlds` puts into a folder of its
own. By hand, in this folder:

    pip install 'aicon-torch[compare]' pyrvo==0.4.3
    aicon compare --task crowd:TASK --conditions circle10 circle10_blind --policies aicon orca

Robot and people are discs of one size and speed. The robot sees where it is, its goal, and where
the people are; an episode ends where it touches one. Those of a condition `_blind` do not see it.
"""

from dataclasses import dataclass, field
from typing import Any

import gymnasium
import hands
import numpy as np
import torch
from gymnasium.spaces import Box
from others import needed, readings, world_task
from torch import Tensor

from aicon_torch import (
    Actuator,
    Affine,
    Deterministic,
    Foresight,
    Goal,
    Interconnection,
    NullspaceProjection,
    Policy,
    Sensor,
    WorldModel,
)
from aicon_torch.control import ActionLaw
from aicon_torch.parts import MovingDiscs, Recent, norm
from aicon_torch.resolution import Resolution

# --- the world

STEP, FINE, HORIZON = 0.1, 5, 250  # s; steps of the people in one of these; steps of an episode
RADIUS, SPEED = 0.3, 1.0  # of all of them, m and m/s
SIZE, APART = 4.0, 0.8  # how far from the middle they start, and how far apart at least, m
NEIGHBOURS, AHEAD, SPARE = 10, 5.0, 0.01  # whom a person heeds, for how long, s, and how far off, m
CROWDS = {"circle5": 5, "circle10": 10, "circle20": 20, "streams10": 10}
CONDITIONS = tuple(f"{crowd}{blind}" for blind in ("", "_blind") for crowd in CROWDS)


def simulator(step: float) -> Any:
    """People without anybody yet."""
    return needed("pyrvo", "pyrvo").RVOSimulator(
        step, 2 * SIZE, NEIGHBOURS, AHEAD, AHEAD, RADIUS + SPARE, SPEED
    )


def wanted(places: Any, goals: Any) -> Any:
    """The velocities of those who are alone on their ways, slower in the last metre."""
    to_go = goals - places
    return SPEED * to_go / np.maximum(SPEED, np.linalg.norm(to_go, axis=-1, keepdims=True))


class Crowd(gymnasium.Env[Any, Any]):
    """A robot that goes where it is told, from the south to the north, among people.

    Args:
        crowd: One of CROWDS.
        is_seen: Whether people keep clear of the robot as they do of each other.
    """

    action_space = Box(-SPEED, SPEED, (2,), np.float64)

    def __init__(self, crowd: str, is_seen: bool) -> None:
        self.crowd, self.is_seen = crowd, is_seen
        self.count = CROWDS[crowd]
        self.observation_space = readings({"z_robot": 2, "z_goal": 2, "z_people": 2 * self.count})

    def reset(self, *, seed: int | None = None, options: Any = None) -> Any:
        """Place the people, each opposite its goal."""
        super().reset(seed=seed)
        self.robot, self.goal = np.array([0.0, -SIZE]), np.array([0.0, SIZE])
        starts, goals = [self.robot], [self.goal]
        while len(starts) <= self.count:
            start, goal = self._way(len(starts))
            is_apart = min(np.linalg.norm(start - other) for other in starts) > APART
            if is_apart and min(np.linalg.norm(goal - other) for other in goals) > APART:
                starts.append(start)
                goals.append(goal)

        self.people, self.goals = np.array(starts[1:]), np.array(goals[1:])
        self.world = simulator(STEP / FINE)
        for start in starts if self.is_seen else starts[1:]:
            self.world.add_agent(start.tolist())
        return self._seen()

    def step(self, action: Any) -> Any:
        """Move, the people by steps of their own."""
        velocity = np.asarray(action, np.float64)
        velocity = velocity / max(1.0, float(np.linalg.norm(velocity)) / SPEED)
        for _ in range(FINE):
            self._move_people(velocity)
            self.robot = self.robot + velocity * STEP / FINE
            if self._nearest() < 2 * RADIUS:
                break
        observation, info = self._seen()
        return observation, 0.0, info["is_success"] or info["collision"], False, info

    def _way(self, number: int) -> Any:
        """Where somebody might start and want to go."""
        if self.crowd.startswith("circle"):
            angle = self.np_random.uniform(0.0, 2 * np.pi)
            start = SIZE * np.array([np.cos(angle), np.sin(angle)])
            start = start + self.np_random.uniform(-SPEED / 2, SPEED / 2, 2)
            return start, -start

        # Two streams between start and goal of the robot, from either side.
        side = 1.0 if number % 2 else -1.0
        start = self.np_random.uniform((SIZE / 4, 1.0 - SIZE), (2 * SIZE, SIZE - 1.0))
        return start * (side, 1.0), start * (-side, 1.0)

    def _move_people(self, velocity: Any) -> None:
        """A fine step of the people, of whom the robot is one if it is seen."""
        first = int(self.is_seen)
        if self.is_seen:
            self.world.set_agent_position(0, self.robot.tolist())
            self.world.set_agent_velocity(0, velocity.tolist())
        for number, way in enumerate(wanted(self.people, self.goals).tolist(), first):
            self.world.set_agent_pref_velocity(number, way)
        self.world.do_step()
        numbers = range(first, first + self.count)
        places = [self.world.get_agent_position(number).to_tuple() for number in numbers]
        self.people = np.array(places)

    def _nearest(self) -> float:
        return float(np.linalg.norm(self.people - self.robot, axis=1).min())

    def _seen(self) -> Any:
        distance = float(np.linalg.norm(self.robot - self.goal))
        touches = self._nearest() < 2 * RADIUS
        info = {"position": self.robot, "distance": distance, "collision": touches}
        info["is_success"] = distance < RADIUS and not touches
        places = {"z_robot": self.robot, "z_goal": self.goal, "z_people": self.people.ravel()}
        return places, info


# --- the policy


@dataclass(frozen=True)
class Options:
    """What is set by hand."""

    people: int = 10
    length: float = 0.06  # of the likelihood that one comes near, m
    spread: float = 0.1  # by how much longer it is for each second ahead, m/s
    horizon: float = 3.0  # for how long people are followed, s
    resolution: Resolution = field(default_factory=NullspaceProjection)
    law: ActionLaw = field(default_factory=Foresight)


PRESETS = hands.PRESETS | {"without_spread": {"spread": 0.0}}


def build(options: Options) -> Policy:
    """The robot: two goals meet at the place where an action leads."""
    people = MovingDiscs(2 * RADIUS, STEP, options.length, options.spread, options.horizon)

    def far(p_robot: Tensor, z_goal: Tensor) -> Tensor:
        return norm(p_robot - z_goal)

    sizes = {"z_robot": 2, "z_goal": 2, "z_people": 2 * options.people}
    near = Interconnection(people, ["p_robot", "z_people_recent"])
    model = WorldModel(
        sensors={name: Sensor(size, "m") for name, size in sizes.items()},
        actuators={"a": Actuator(2, "m/s", limit=SPEED)},
        estimators=[
            Deterministic("p_robot", Affine(z_robot=1.0, a="dt")),
            Recent("z_people", 2),
        ],
        goals=[Goal("reach", far), Goal("avoid", near)],
        dt=STEP,
        dtype=torch.float64,
    )
    return Policy(model, options.resolution, options.law)


# --- the opponent


@dataclass
class Orca:
    """ORCA steers the robot, too; it tells velocities by where all were a step before."""

    spare: float = 0.1  # how much wider than they are it takes all to be, m

    def predict(
        self,
        observation: Any,
        state: Any = None,
        episode_start: Any = None,
        deterministic: bool = True,
    ) -> Any:
        """The velocities of the robots of a batch, and where all are."""
        places = np.concatenate([observation["z_robot"], observation["z_people"]], axis=-1)
        places = places.reshape(len(places), -1, 2)
        before = places if state is None else state
        if episode_start is not None:
            before = np.where(np.asarray(episode_start)[:, None, None], places, before)
        rows = zip(observation["z_goal"], places, (places - before) / STEP, strict=True)
        return np.array([self._steered(*row) for row in rows]), places

    def _steered(self, goal: Any, places: Any, velocities: Any) -> Any:
        """The velocity of a robot, the first of all."""
        world, radius = simulator(STEP), RADIUS + self.spare
        for place, velocity in zip(places.tolist(), velocities.tolist(), strict=True):
            world.add_agent(
                place, 2 * SIZE, NEIGHBOURS, AHEAD, AHEAD, radius, SPEED, velocity
            )  # fmt: skip
        world.set_agent_pref_velocity(0, wanted(places[0], goal).tolist())
        world.do_step()
        return world.get_agent_velocity(0).to_tuple()


@dataclass
class OrcaClose(Orca):
    """With no more to spare than people have."""

    spare: float = SPARE


# --- the task


def crowd(condition: str, **options: Any) -> Crowd:
    """The world of a condition."""
    name, _, blind = condition.partition("_")
    return Crowd(name, not blind, **options)


def policy_options(condition: str) -> dict[str, Any]:
    """How many people there are."""
    return {"people": CROWDS[condition.partition("_")[0]]}


TASK = world_task(
    __name__,
    crowd,
    CONDITIONS,
    PRESETS,
    time_step=STEP,
    horizon=HORIZON,
    maps=("plane",),
    time_unit="s",
    policy_options=policy_options,
    agents={"orca": f"{__name__}:Orca", "orca_close": f"{__name__}:OrcaClose"},
)
