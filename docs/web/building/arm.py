"""The page about an arm: three joints in a plane, made of the library's parts."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

import torch
from torch import Tensor

from aicon_torch import (
    ActionLaw,
    Actuator,
    Affine,
    Deterministic,
    Foresight,
    Goal,
    Interconnection,
    KalmanFilter,
    Measurement,
    NullspaceProjection,
    Policy,
    Resolution,
    Sensor,
    WorldModel,
)
from aicon_torch.parts import (
    Capsule,
    CapsuleSegments,
    Chain,
    EndEffector,
    Joint,
    JointLimits,
    Obstacle,
    PoseReach,
    SquaredHinge,
    TipPose,
)

DT, SPEED, STOP = 0.02, 1.5, 2.6
"""Time step, s; largest speed of a joint, rad/s; where its stops are, ± rad."""

LINKS, THICKNESS, BALL = (0.4, 0.35, 0.25), 0.03, 0.07
"""Lengths of the links, their radius and that of the ball, m."""


@dataclass(frozen=True)
class Options:
    """What the page switches.

    Attributes:
        resolution: What happens where gradients meet.
        law: From the gradients to the action.
    """

    resolution: Resolution = field(default_factory=NullspaceProjection)
    law: ActionLaw = field(default_factory=Foresight)


PRESETS: Mapping[str, Mapping[str, Any]] = MappingProxyType({"aicon": {}})
"""The one that there is."""


def build(options: Options) -> Policy:
    """Its tip goes to a target, its links keep off a ball, and its joints off their stops."""
    chain, pose = make_chain(), TipPose("free")
    capsules = [
        Capsule(number, (0.0, 0.0, 0.0), (length, 0.0, 0.0), THICKNESS)
        for number, length in enumerate(LINKS, start=1)
    ]
    ball = Obstacle(BALL, capsules, SquaredHinge(margin=0.08, weight=0.5))
    stops = JointLimits([-STOP] * 3, [STOP] * 3, SquaredHinge(margin=0.15, weight=0.05))
    agreement = Measurement(Affine(q=1.0, z_joints=-1.0), noise=1e-8, size=3)

    model = WorldModel(
        sensors={
            "z_joints": Sensor(3, "rad"),
            "z_target": Sensor(3, "m"),
            "z_ball": Sensor(3, "m"),
        },
        actuators={"a": Actuator(3, "rad/s", limit=SPEED)},
        estimators=[
            KalmanFilter(
                "q",
                "P_q",
                predict=Affine(q=1.0, a="dt"),
                noise=1e-6,
                initial=([0.0] * 3, 10.0),
                correct=[agreement],
            ),
            Deterministic("target", seen_target),
            Deterministic("ball", seen_ball),
            Deterministic("tip", Interconnection(EndEffector(chain, pose, damping=0.05), ["q"])),
            Deterministic("body", Interconnection(CapsuleSegments(chain, capsules), ["q"])),
        ],
        goals=[
            Goal("reach", Interconnection(PoseReach(pose, tolerance=0.005), ["tip", "target"])),
            Goal("keep off", Interconnection(ball, ["body", "ball"])),
            Goal("stops", Interconnection(stops, ["q"])),
        ],
        dt=DT,
        dtype=torch.float64,
    )
    return Policy(model, options.resolution, options.law)


def make_chain() -> Chain:
    """The joints turn about z, one link after the other along x."""
    fixed = [shift(length) for length in (0.0, *LINKS[:-1])]
    joints = [Joint(f"joint_{k}", low=-STOP, high=STOP, speed=SPEED) for k in (1, 2, 3)]
    return Chain(fixed, shift(LINKS[-1]), joints)


def shift(x: float) -> list[list[float]]:
    """A transform that shifts along x, m."""
    return [[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]


def seen_target(z_target: Tensor) -> Tensor:
    """The target as it is seen, m."""
    return 1.0 * z_target


def seen_ball(z_ball: Tensor) -> Tensor:
    """The ball as it is seen, m."""
    return 1.0 * z_ball


def sizes() -> dict[str, Any]:
    """What the page draws and moves."""
    sizes = {"links": LINKS, "thickness": THICKNESS, "ball": BALL}
    return {**sizes, "dt": DT, "speed": SPEED, "stop": STOP}
