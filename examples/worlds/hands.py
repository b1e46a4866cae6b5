"""The graphs of hands that are told how far to go: to reach a place, and to push a thing to one.

What a world adds is its :class:`Hand`; what is set by hand, :class:`Options`, is the same in all.
"""

import math
from dataclasses import dataclass, field
from typing import Any

import torch
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
    Sensor,
    WorldModel,
)
from aicon_torch.control import ActionLaw
from aicon_torch.parts import (
    ContactOptions,
    DisplacementCommand,
    Lag,
    PoseMotion,
    RigidObject,
    closest_point,
    norm,
)
from aicon_torch.resolution import Resolution, SteepestPath


@dataclass(frozen=True)
class Hand:
    """What is told to go, and how it does.

    Attributes:
        time_step: s.
        stride: How far a command of 1 sends it in a step, m.
        radius: Of what pushes, m.
    """

    time_step: float
    stride: float
    radius: float

    @property
    def speed(self) -> float:
        """The fastest that it can be told, m/s."""
        return self.stride / self.time_step

    def actuator(self, name: str, size: int) -> Actuator:
        """Its velocity in some directions, sent as a displacement."""
        command = Interconnection(DisplacementCommand(self.stride), [name, "dt"])
        return Actuator(size, "m/s", limit=self.speed, command=command, command_range=(-1.0, 1.0))


@dataclass(frozen=True)
class Options:
    """What is set by hand."""

    task: str = "reach"  # or "push"
    lag: float = 0.08  # with which a hand's velocity follows, s
    size: float = 0.2  # of which the ranges of a contact are shares, m
    tolerance: float = 0.03  # of the place to which a thing is pushed, m
    resolution: Resolution = field(default_factory=NullspaceProjection)
    law: ActionLaw = field(default_factory=lambda: Foresight(smoothing=0.1))


PRESETS: dict[str, dict[str, Any]] = {
    "aicon": {},
    "without_exploration": {"resolution.exploration": None},
    "weighted_sum": {"resolution.projector": "none"},
    "without_foresight": {"law": DirectDescent()},
    "steepest": {"resolution": SteepestPath()},
}


def regular(corners: int, radius: float) -> RigidObject:
    """A thing with so many sides, m from its middle to each; one of them faces x."""
    angles = [(2 * i + 1) * math.pi / corners for i in range(corners)]
    outer = radius / math.cos(math.pi / corners)
    return RigidObject.of([(outer * math.cos(t), outer * math.sin(t)) for t in angles])


def reach_policy(hand: Hand, options: Options) -> Policy:
    """The hand goes to z_goal, from z_hand, moving at v_hand."""
    lag = Lag(options.lag)

    def ahead(z_hand: Tensor, v_hand: Tensor, a: Tensor, dt: Tensor) -> Tensor:
        return z_hand + lag.displacement(a, v_hand, dt)

    def far(p_hand: Tensor, z_goal: Tensor) -> Tensor:
        return norm(p_hand - z_goal)

    model = WorldModel(
        sensors={name: Sensor(3, "SI") for name in ("z_hand", "v_hand", "z_goal")},
        actuators={"a": hand.actuator("a", 3)},
        estimators=[Deterministic("p_hand", ahead)],
        goals=[Goal("reach", far)],
        dt=hand.time_step,
        dtype=torch.float64,
    )
    return Policy(model, options.resolution, options.law)


def push_policy(hand: Hand, body: RigidObject, options: Options) -> Policy:
    """The hand pushes a body at z_pose in the plane, until its centre is at z_goal, and square."""
    lag, contact = Lag(options.lag), ContactOptions(size=options.size)
    dynamics = contact.dynamics(body)
    pushed, quarter = PoseMotion(dynamics, hand.radius), math.pi / 2

    def way(a: Tensor, v_hand: Tensor, dt: Tensor) -> Tensor:
        return lag.displacement(a, v_hand[..., :2], dt)

    def place(z_hand: Tensor, d_pusher: Tensor) -> Tensor:
        return z_hand[..., :2] + d_pusher

    def low(z_hand: Tensor, v_hand: Tensor, lift: Tensor, dt: Tensor) -> Tensor:
        return z_hand[..., 2:] + lag.displacement(lift, v_hand[..., 2:], dt)

    def far(x_obj: Tensor, z_goal: Tensor) -> Tensor:
        turn = torch.remainder(x_obj[..., 2:] + quarter / 2, quarter) - quarter / 2
        aside = x_obj[..., :2] - z_goal[..., :2]
        return norm(torch.cat((aside, dynamics.rotation_length * turn), dim=-1))

    def high(p_height: Tensor, z_goal: Tensor) -> Tensor:
        return norm(p_height - z_goal[..., 2:])

    model = WorldModel(
        sensors={name: Sensor(3, "SI") for name in ("z_hand", "v_hand", "z_pose", "z_goal")},
        actuators={"a": hand.actuator("a", 2), "lift": hand.actuator("lift", 1)},
        estimators=[
            Deterministic("d_pusher", way),
            Deterministic("x_pusher", place),
            Deterministic("p_height", low),
            Deterministic("x_pose", Interconnection(pushed, ["z_pose", "x_pusher", "d_pusher"])),
            Deterministic("x_keypoints", Interconnection(body.keypoints_at, ["x_pose"])),
            Deterministic("x_side", body.sides),
            Deterministic("x_contact", closest_point, each=["x_side"]),
            Deterministic(
                "p_contact", contact.likelihood(hand.radius), each=["x_side", "x_contact"]
            ),
            Deterministic("x_obj", dynamics),
        ],
        goals=[Goal("push", far, tolerance=options.tolerance), Goal("low", high)],
        dt=hand.time_step,
        dtype=torch.float64,
    )
    return Policy(model, options.resolution, options.law)
