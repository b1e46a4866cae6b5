"""An arm behind a shield: its joints go straight where they shall be, and balls are in the way."""

from dataclasses import dataclass
from functools import cache
from typing import Any

import gymnasium
import numpy as np
import torch
from gymnasium import spaces
from numpy.typing import NDArray

from aicon_baselines.agents.shields.clamped import Clamped
from aicon_baselines.evaluation.predictor import Predictor
from aicon_baselines.tasks.side_by_side import SideBySide, side_by_side
from aicon_envs.reach import ReachEnv
from aicon_envs.reach.robots import ROBOTS, find_file
from aicon_envs.reach.simulation import CONTROL_STEP
from aicon_torch import WorldModel
from aicon_torch.models.reach import Options, Robot, body_model
from aicon_torch.parts import CapsuleSegments, Obstacle, SquaredHinge
from aicon_torch.shield import Shield

SPEED, BALL = 1.5, 0.05
"""The largest speed of a joint, rad/s, and the radius of a ball, m."""

MOVING, BALL_SPEED = 3, 0.2
"""So many balls move at once, at up to so many m/s."""

SETTLING = 0.1
"""A joint goes where it shall be in so long, s, as far as its speed allows."""

NEAR = 0.03
"""A joint has arrived within this, rad."""

ROOM = 0.05
"""So far from a ball at rest does the arm begin and end, m."""


@dataclass(frozen=True)
class Straight:
    """Every joint straight to where it shall be, whatever is in the way."""

    def predict(
        self, observation: dict[str, NDArray[Any]], *_: Any, **__: Any
    ) -> tuple[NDArray[Any], Any]:
        """Velocities (B, n), rad/s."""
        velocity = (observation["target_joints"] - observation["q"]) / SETTLING
        fastest = np.abs(velocity).max(-1, keepdims=True)
        return velocity * np.minimum(1.0, SPEED / np.maximum(fastest, 1e-9)), None


class Posture(gymnasium.Wrapper[Any, Any, Any, Any]):
    """An SO-101 that shall take a posture, and a ball where its tip would be halfway.

    The ball leaves room at both ends. Where the joints shall be is in the observation,
    `target_joints` (n,), rad.

    Args:
        is_moving: Whether there are several balls instead that go to and fro about the way, where
            they come neither near the base nor near the arm at its end.
    """

    def __init__(self, is_moving: bool = False) -> None:
        balls, speed = (MOVING, BALL_SPEED) if is_moving else (1, 0.0)
        env = ReachEnv(
            "so101",
            "axis",
            "random",
            speed=SPEED,
            balls=balls,
            ball_radius=BALL,
            ball_speed=speed,
        )

        super().__init__(env)
        self._arm, self._is_moving = env, is_moving

        seen = env.observation_space
        assert isinstance(seen, spaces.Dict)
        self.observation_space = spaces.Dict({**seen.spaces, "target_joints": seen["q"]})

    def reset(self, **arguments: Any) -> tuple[Any, dict[str, Any]]:
        """Start an episode."""
        while True:
            observation, info = super().reset(**arguments)
            self._target, start = info["target_joints"], observation["q"]
            if self._is_moving:
                return self._seen(observation, info)

            ball = _tip((start + self._target) / 2)
            if min(_distance(start, ball), _distance(self._target, ball)) > ROOM:
                break
            arguments = {}  # drawn anew from the same generator

        self._arm.move_ball(1, ball)
        return self._seen(observation | {"ball_1": ball}, info)

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Move by one control step of 0.02 s."""
        observation, reward, _, truncated, info = super().step(action)
        observation, info = self._seen(observation, info)
        return observation, reward, bool(info["is_success"]), truncated, info

    def _seen(
        self, observation: dict[str, Any], info: dict[str, Any]
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        """With the target, and what counts: all joints, of which the tip is the consequence."""
        distance = np.abs(self._target - observation["q"]).max()
        told = {"is_success": bool(distance < NEAR), "position": observation["q"]}
        return observation | {"target_joints": self._target}, info | told


@cache
def robot() -> Robot:
    """The arm, with its shape."""
    described = ROBOTS["so101"]
    return Robot.from_urdf(find_file(described.urdf), tip=described.tip)


def _tip(joints: NDArray[Any]) -> NDArray[Any]:
    """Where the tip is, (3,), m."""
    place: NDArray[Any] = robot().chain(torch.as_tensor(joints))[:3, 3].numpy()
    return place


def _distance(joints: NDArray[Any], ball: NDArray[Any]) -> float:
    """How far the arm is from a ball, m."""
    shape = robot().shape
    assert shape is not None
    segments = CapsuleSegments(robot().chain, shape.capsules)(torch.as_tensor(joints))
    obstacle = Obstacle(BALL, shape.capsules, SquaredHinge(ROOM, 1.0))
    return float(obstacle.distances(segments, torch.as_tensor(ball)).min())


def shielded(policy: Predictor, goes_around: bool = True, balls: int = 1) -> Shield:
    """A shield around a policy that proposes velocities of the joints, rad/s, compiled."""
    return Shield(policy, model(balls), goes_around=goes_around).compile()


def model(balls: int = 1) -> WorldModel:
    """The arm, and the balls that it sees."""
    return body_model(
        Options(robot=robot(), speed=SPEED, dt=CONTROL_STEP, balls=balls, ball_radius=BALL)
    )


def clamped(policy: Predictor) -> Clamped:
    """A policy of which no joint goes farther in a step than LeRobot's own check allows."""
    return Clamped(policy, lambda action, _: np.clip(action, -SPEED / 2, SPEED / 2))


def make_env(number: int, horizon: int, is_moving: bool = False) -> SideBySide:
    """Episodes with a ball on the way, or several that move about it."""
    return side_by_side(lambda: Posture(is_moving), number, horizon)
