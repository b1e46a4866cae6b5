"""The graphs of hands that are told how far to go: to reach a place, and to push a thing to one.

What a world adds is its :class:`Hand`; what is set by hand, :class:`Options`, is the same in all.
"""

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
from aicon_torch.differentiation import stop
from aicon_torch.control import ActionLaw
from aicon_torch.parts import (
    DisplacementCommand,
    Lag,
    norm,
)
from aicon_torch.parts.round_object import RoundObject, Sliding
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
    lag: float = 0.001
    share: float = 1.0

    @property
    def speed(self) -> float:
        """The fastest that it can be told, m/s."""
        return self.stride / self.time_step

    def actuator(self, name: str, size: int) -> Actuator:
        """Its velocity in some directions, sent as a displacement."""
        command = Interconnection(DisplacementCommand(self.stride), [name, "dt"])
        return Actuator(size, "m/s", limit=self.share * self.speed, command=command, command_range=(-1.0, 1.0))


@dataclass(frozen=True)
class Options:
    """What is set by hand."""

    task: str = "reach"  # or "push"
    lag: float = 0.08  # with which a hand's velocity follows, s
    step: float = 0.05
    rot: float = 1.55
    table: float = 1.0
    coast: float = 1.0
    mu: float = 1.0
    parts: int = 1
    aim: float = 1 / 15
    inset: float = 0.0
    shape: float = 1.15
    gyr: float | None = None
    square: bool = True
    steer: bool = True
    size: float = 0.2  # of which the ranges of a contact are shares, m
    tolerance: float = 0.03  # of the place to which a thing is pushed, m
    resolution: Resolution = field(default_factory=NullspaceProjection)
    law: ActionLaw = field(default_factory=lambda: Foresight(smoothing=0.02))


PRESETS: dict[str, dict[str, Any]] = {
    "aicon": {},
    "without_exploration": {"resolution.exploration": None},
    "weighted_sum": {"resolution.projector": "none"},
    "without_foresight": {"law": DirectDescent()},
    "steepest": {"resolution": SteepestPath()},
}


def reach_policy(hand: Hand, options: Options) -> Policy:
    """The hand goes to z_goal, from z_hand, moving at v_hand."""
    lag = Lag(hand.lag)

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


def push_policy(hand: Hand, radius: float, options: Options) -> Policy:
    """The hand pushes a thing at z_place, that moves at v_obj, until it rests at z_goal."""
    lag, slides = Lag(hand.lag), Sliding(options.table)
    body = RoundObject(radius, hand.radius, options.mu, options.size/4, options.size/12, options.step)

    def way(a: Tensor, v_hand: Tensor, dt: Tensor) -> Tensor:
        return lag.displacement(a, v_hand[..., :2], dt)

    def place(z_hand: Tensor, d_pusher: Tensor) -> Tensor:
        return z_hand[..., :2] + d_pusher

    def low(z_hand: Tensor, v_hand: Tensor, lift: Tensor, dt: Tensor) -> Tensor:
        return z_hand[..., 2:] + lag.displacement(lift, v_hand[..., 2:], dt)

    def slid(z_place: Tensor, v_obj: Tensor, dt: Tensor) -> Tensor:
        return z_place + slides.displacement(v_obj, dt)

    def rest(z_place: Tensor, x_slid: Tensor, d_push: Tensor, v_obj: Tensor, dt: Tensor) -> Tensor:
        pushed = norm(d_push).unsqueeze(-1) > 1e-6
        speed = norm(v_obj).unsqueeze(-1)
        slowed = v_obj * (1 - options.table * 9.81 * dt / speed.clamp(min=1e-9)).clamp(min=0)
        velocity = torch.where(pushed, (x_slid + d_push - z_place) / dt, slowed)
        return x_slid + d_push + options.coast * slides.to_rest(velocity)

    def far(x_obj: Tensor, z_goal: Tensor) -> Tensor:
        return norm(x_obj - z_goal[..., :2])

    def high(p_height: Tensor, z_goal: Tensor) -> Tensor:
        return norm(p_height - z_goal[..., 2:])

    sensors = {name: Sensor(3, "SI") for name in ("z_hand", "v_hand", "z_goal")}
    model = WorldModel(
        sensors=sensors | {name: Sensor(2, "SI") for name in ("z_place", "v_obj")},
        actuators={"a": hand.actuator("a", 2), "lift": hand.actuator("lift", 1)},
        estimators=[
            Deterministic("d_pusher", way),
            Deterministic("x_pusher", place),
            Deterministic("p_height", low),
            Deterministic("x_slid", slid),
            Deterministic("d_push", Interconnection(body.push, ["x_slid", "x_pusher", "d_pusher"])),
            Deterministic("x_rest", rest),
            Deterministic("n_contact", Interconnection(body.normal, ["x_pusher", "x_rest"])),
            Deterministic("p_contact", Interconnection(body.likelihood, ["x_pusher", "x_rest"])),
            Deterministic("x_obj", body.moved),
        ],
        goals=[Goal("push", far, tolerance=options.tolerance), Goal("low", high)],
        dt=hand.time_step,
        dtype=torch.float64,
    )
    return Policy(model, options.resolution, options.law)
