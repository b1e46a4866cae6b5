"""Navigation behind a shield: it feels a clearance, and knows neither a target nor a map."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from torch import Tensor

from aicon_baselines.agents.shields.clamped import Clamped, shortened
from aicon_baselines.evaluation.predictor import Predictor
from aicon_envs.nav2d import Physics
from aicon_torch import Actuator, Deterministic, Goal, Sensor, WorldModel
from aicon_torch.dampers import VelocityDampers
from aicon_torch.models.nav2d.graph import displacement
from aicon_torch.parts import Clearance, clock
from aicon_torch.parts.clearance import certain_clearance
from aicon_torch.shield import Shield
from aicon_torch.vectors import shorten

MARGIN = 0.1
"""What is kept of the clearance beyond its uncertainty, m."""

BRAKING = 0.2
"""The way on which it brakes, m."""

TIME, SLOWEST = 0.2, 0.05
"""The clearance is not used up in less than so long, s, but for a speed at which it feels, m/s."""


def shielded(policy: Predictor, goes_around: bool = True) -> Shield:
    """A shield around a policy that proposes velocities, m/s, compiled."""
    return Shield(policy, model(), goes_around=goes_around).compile()


def model() -> WorldModel:
    """The walls that are felt: a clearance d, in whatever direction it grows."""
    physics = Physics()

    walls = Clearance(
        "x_wall",
        "z_wall",
        noise=physics.range_noise,
        motion_noise=physics.actuation_noise * physics.dt,
        dt=physics.dt,
    )

    velocity = Actuator(
        2,
        "m/s",
        limit=physics.max_speed,
        constraints=[slowed],
        dampers=VelocityDampers(braking=BRAKING),
    )

    return WorldModel(
        sensors={
            "z_wall": Sensor(1, "m", key="range", range=(-1.0, 20.0), max_gap=physics.dt),
            "z_elapsed": clock(),
        },
        actuators={"a": velocity},
        estimators=[Deterministic("x_rob", displacement, is_motion=True), walls.estimator()],
        goals=[Goal("walls", too_near, safety=True)],
        dt=physics.dt,
        clock="z_elapsed",
    )


def too_near(x_wall: Tensor, P_wall: Tensor) -> Tensor:
    """What is missing to the margin, m + 2σ − d, ``(*B,)``, m."""
    return MARGIN - certain_clearance(x_wall, P_wall)


def slowed(a: Tensor, x_wall: Tensor, P_wall: Tensor) -> Tensor:
    """A velocity of at most (d − 2σ)/τ, ``(*B, 2)``, m/s: the wall's direction may be wrong."""
    fastest = certain_clearance(x_wall, P_wall).unsqueeze(-1) / TIME
    return shorten(a, fastest.clamp(min=SLOWEST))


@dataclass(frozen=True)
class Straight:
    """Straight to the target, whatever is in the way."""

    def predict(
        self, observation: dict[str, NDArray[Any]], state: Any = None, *_: Any, **__: Any
    ) -> tuple[NDArray[Any], Any]:
        """Full speed along the bearing, (B, 2), m/s."""
        angle = observation["bearing"].astype(np.float64)
        return Physics().max_speed * np.concatenate([np.cos(angle), np.sin(angle)], -1), None


class Wandering:
    """Random velocities that stay the same for a while, and are often too fast.

    Args:
        hold: For how many steps in the mean.
    """

    def __init__(self, hold: float = 40.0, seed: int = 0) -> None:
        self._random, self._hold = np.random.default_rng(seed), hold

    def predict(
        self, observation: dict[str, NDArray[Any]], state: Any = None, *_: Any, **__: Any
    ) -> tuple[NDArray[Any], Any]:
        """Velocities (B, 2), m/s."""
        count = len(observation["range"])
        drawn = self._random.normal(0.0, Physics().max_speed, (count, 2))
        changes = self._random.random((count, 1)) < 1.0 / self._hold
        action = drawn if state is None else np.where(changes, drawn, state)
        return action, action


def clamped(policy: Predictor) -> Clamped:
    """A policy whose speed is clamped to the clearance that is left: (d − m)/τ."""
    return Clamped(policy, within_clearance)


def within_clearance(action: NDArray[Any], observation: Mapping[str, Any]) -> NDArray[Any]:
    """The velocity (B, 2), m/s."""
    fastest = np.clip((observation["range"] - MARGIN) / TIME, 0.0, Physics().max_speed)
    return shortened(action, fastest)
