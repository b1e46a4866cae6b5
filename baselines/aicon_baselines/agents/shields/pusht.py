"""pushT behind a shield: a disc on the board that the pusher must not enter."""

from collections.abc import Mapping
from dataclasses import replace
from itertools import count
from typing import Any, cast

import gymnasium
import numpy as np
from numpy.typing import NDArray
from torch import Tensor

from aicon_baselines.ablations import PIXEL
from aicon_baselines.agents.shields.clamped import Clamped
from aicon_baselines.evaluation.predictor import Predictor
from aicon_baselines.tasks.side_by_side import SideBySide, side_by_side
from aicon_envs.pusht import PushTEnv
from aicon_envs.to_and_fro import ToAndFro
from aicon_torch import Goal, Sensor, WorldModel
from aicon_torch.dampers import VelocityDampers
from aicon_torch.models.pusht.benchmark import GOAL_POSE, SUBSTEP
from aicon_torch.models.pusht.interface import actuator
from aicon_torch.models.pusht.options import Options
from aicon_torch.models.pusht.pusher import pusher_estimators
from aicon_torch.parts.obstacle import moving_point
from aicon_torch.parts.servo import Servo
from aicon_torch.shield import Shield

RADIUS = 40.0
"""Of the region, px."""

MARGIN = 8.0
"""What is kept from it, px: within a step the pusher's controller may swing out."""

BRAKING = 0.1
"""The way on which the pusher brakes, m."""

IN_THE_WAY = 100
"""So often a region in the way is drawn, and any if none fits."""

AMPLITUDE, SPEED = 80.0, 40.0
"""A region that moves goes to and fro, so far to each side, px, and at most so fast, px/s."""

NOISE, ACCELERATION = 1e-3, 1.0
"""How well the middle of a region is seen, m, and how fast its velocity changes, m/s²."""

SERVO = Servo.of(substep=SUBSTEP)


def shielded(policy: Predictor, goes_around: bool = True) -> Shield:
    """A shield around a policy that proposes places to go to, px, compiled."""
    return Shield(policy, model(), nominal=mean_velocity, goes_around=goes_around).compile()


def model() -> WorldModel:
    """The pusher, its controller, and the region that it sees, with its velocity."""
    options = Options()
    region = moving_point(
        "x_region", "z_region", options.dt, NOISE, ACCELERATION, SPEED * PIXEL, size=2
    )

    velocity = replace(actuator(options, SERVO), dampers=VelocityDampers(braking=BRAKING))

    return WorldModel(
        sensors={
            "z_pusher": Sensor(2, "m", key="agent_pos", scale=PIXEL),
            "z_region": Sensor(2, "m", key="region", scale=PIXEL),
        },
        actuators={"a": velocity},
        estimators=[*pusher_estimators(options, SERVO), region],
        goals=[Goal("region", inside, safety=True)],
        dt=options.dt,
        dtype=options.dtype,
    )


def inside(x_pusher: Tensor, x_region: Tensor) -> Tensor:
    """How far it is inside, r + m − ‖x − c‖, ``(*B,)``, m."""
    distance = (x_pusher - x_region[..., :2]).square().sum(-1).clamp(min=1e-12).sqrt()
    return (RADIUS + MARGIN) * PIXEL - distance


def mean_velocity(proposal: Tensor, x_pusher: Tensor, v_pusher: Tensor, dt: Tensor) -> Tensor:
    """The mean velocity in a step that a place in px brings about, ``(*B, 2)``, m/s."""
    offset = proposal * PIXEL - x_pusher
    moved = SERVO.displacement_by_offset[-1] * offset
    return (moved + SERVO.displacement_by_velocity[-1] * v_pusher) / dt


def clamped(policy: Predictor) -> Clamped:
    """A policy whose places are clamped to the outside of the region."""
    return Clamped(policy, outside)


def outside(place: NDArray[Any], observation: Mapping[str, Any]) -> NDArray[Any]:
    """The place (B, 2), px."""
    middle = observation["region"]
    away = place - middle
    distance = np.maximum(np.linalg.norm(away, axis=-1, keepdims=True), 1e-9)
    moved: NDArray[Any] = middle + away * np.maximum(1.0, (RADIUS + MARGIN) / distance)
    return moved


class Region(gymnasium.Wrapper[Any, Any, Any, Any]):
    """A region that the pusher must not enter, on its way to the object or near it.

    Its middle is in the observation, `region` (2,), px; `info["collision"]` says whether the pusher
    was inside in this step, or in one of the sub-steps of its controller.

    Args:
        env: pushT.
        is_moving: Whether it goes to and fro.
    """

    def __init__(self, env: gymnasium.Env[Any, Any], is_moving: bool = False) -> None:
        super().__init__(env)
        region = gymnasium.spaces.Box(0.0, 512.0, (2,), np.float64)
        seen = cast(gymnasium.spaces.Dict, env.observation_space)
        self.observation_space = gymnasium.spaces.Dict({**seen.spaces, "region": region})
        self._amplitude = AMPLITUDE if is_moving else 0.0

    def reset(self, **arguments: Any) -> tuple[Any, dict[str, Any]]:
        """Start an episode; the region hangs on its seed."""
        observation, info = super().reset(**arguments)
        random = np.random.default_rng(arguments["seed"])
        self._track = _drawn(observation, self._amplitude, random)
        self._before, self._time = info, 0.0
        return observation | {"region": self._track.at(0.0)}, info

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Move by one control step."""
        place, velocity = self._before["pos_agent"], self._before["vel_agent"]
        observation, reward, terminated, truncated, info = super().step(action)

        offset = np.clip(action, 0.0, 512.0) - place
        by_offset = np.outer(SERVO.displacement_by_offset, offset)
        way = place + by_offset + np.outer(SERVO.displacement_by_velocity, velocity)
        times = self._time + SUBSTEP * (1 + np.arange(len(way)))
        middles = [self._track.at(time) for time in times]
        nearest = np.linalg.norm(way - middles, axis=-1).min()

        self._before, self._time = info, float(times[-1])
        info = info | {"collision": bool(nearest < RADIUS)}
        seen = observation | {"region": self._track.at(self._time)}
        return seen, reward, terminated, truncated, info


def _drawn(observation: Any, amplitude: float, random: np.random.Generator) -> ToAndFro:
    """A region between pusher and object where it fits; off both at first, and always off the goal.

    One that moves stays within the board.
    """
    goal = np.asarray(GOAL_POSE[:2]) / PIXEL
    pusher, corners = observation["agent_pos"], observation["environment_state"].reshape(-1, 2)
    for attempt in count():
        between = pusher + random.uniform(0.3, 0.8) * (corners.mean(0) - pusher)
        middle = between if attempt < IN_THE_WAY else random.uniform(RADIUS, 512.0 - RADIUS, 2)
        track = ToAndFro(middle, np.zeros(2), 0.0, 0.0)
        if amplitude > 0.0:
            angle, phase = random.uniform(-np.pi, np.pi, 2)
            way = amplitude * np.array([np.cos(angle), np.sin(angle)])
            track = ToAndFro(middle, way, SPEED / AMPLITUDE, phase)

        first, ends = track.at(0.0), track.everywhere(3)
        is_off_goal = np.linalg.norm(ends - goal, axis=-1).min() > 70.0 + RADIUS
        is_off_object = np.linalg.norm(corners - first, axis=-1).min() > 30.0 + RADIUS
        is_off_pusher = np.linalg.norm(pusher - first) > 20.0 + RADIUS
        is_on_board = amplitude == 0.0 or np.abs(ends - 256.0).max() < 256.0 - RADIUS
        if is_off_goal and is_off_object and is_off_pusher and is_on_board:
            break
    return track


def make_env(number: int, horizon: int, is_moving: bool = False) -> SideBySide:
    """Episodes of pushT with a region each."""
    return side_by_side(lambda: Region(PushTEnv(), is_moving), number, horizon)
