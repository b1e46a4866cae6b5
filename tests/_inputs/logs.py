"""Logs of the shipped models: what was read and done, and which of their numbers learn."""

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import torch
from torch import Tensor, nn

from _inputs.arm import HOME
from _inputs.navigation import drifting
from _inputs.pushing import touching
from _inputs.random_numbers import normal
from _inputs.reaching import planar_arm
from _inputs.shipped import lean
from _inputs.tracking import MOVE, tracked_point, tracking_model
from aicon_torch import Actuator, DirectDescent, Measurement, Policy, Sum

STEPS, ROWS = 11, 2


AGREES = 1e-6
"""How well a slope and its finite differences agree."""


class Log(NamedTuple):
    """A policy, what it read step by step, the names of numbers of each kind, and where some start.

    A number that is zero has no scale, and a clip ends there.
    """

    make: Callable[[], Policy]
    observations: Callable[[], list[dict[str, Tensor]]]
    numbers: tuple[str, ...]
    starts: Mapping[str, Any] = {}

    def learner(self) -> Policy:
        """The policy, whose numbers learn."""
        return self.make().learn(*self.numbers, start=self.starts)


def _swinging(home: Tensor, seed: int = 0) -> Tensor:
    """Joint angles of some steps that swing about a posture, ``(STEPS, ROWS, n)``, rad."""
    time = 0.05 * torch.arange(STEPS, dtype=torch.float64).reshape(-1, 1, 1)
    swing = 0.05 * torch.sin(3 * time + torch.arange(len(home)))
    return home + swing + 0.002 * normal(STEPS, ROWS, len(home), seed=seed)


def _of_the_arm() -> list[dict[str, Tensor]]:
    place = torch.tensor([0.5, -0.05, -0.8], dtype=torch.float64)
    seen = place + 0.003 * normal(STEPS, ROWS, 3, seed=1)
    target = torch.tensor([0.54, 0.05, 0.4], dtype=torch.float64).expand(ROWS, 3)
    joints = _swinging(HOME)
    return [{"q": joints[t], "object_pose": seen[t], "target": target} for t in range(STEPS)]


def _of_reach() -> list[dict[str, Tensor]]:
    target = torch.tensor([-0.3, 0.4, 0.0], dtype=torch.float64).expand(ROWS, 3)
    joints = _swinging(torch.tensor([0.4, 0.6, -0.5], dtype=torch.float64))
    return [{"q": joints[t], "target_position": target} for t in range(STEPS)]


def _of_a_ball() -> list[dict[str, Tensor]]:
    """A ball comes down on the tip, which has to get out of its way."""
    readings = _of_reach()
    for step, reading in enumerate(readings):
        ball = torch.tensor([0.72, 0.63 - 0.02 * step, 0.0], dtype=torch.float64)
        reading["ball_1"] = ball.expand(ROWS, 3)
    return readings


def _double(name: str, **options: Any) -> Callable[[], Policy]:
    return lambda: lean(name, dtype=torch.float64, **options)


class _Seen(nn.Module):
    """A network that says where a point is."""

    def __init__(self) -> None:
        super().__init__()
        torch.manual_seed(0)
        self.layers = nn.Sequential(nn.Linear(2, 4), nn.Tanh(), nn.Linear(4, 2))

    def forward(self, p: Tensor, z: Tensor) -> Tensor:
        seen: Tensor = self.layers(z)
        return p - seen


def _seeing() -> Policy:
    point = tracked_point(correct=[Measurement(_Seen(), 0.1, size=2)])
    actuators = {"a": Actuator(2, "m/s", limit=1.0)}
    model = tracking_model(MOVE, point, actuators=actuators)
    return Policy(model, Sum(), DirectDescent(gain=1.0))


LOGS: dict[str, Log] = {
    "nav2d": Log(
        _double("nav2d"),
        lambda: drifting(STEPS, (ROWS,)),
        (
            "p_tar.noise",
            "p_tar.measurements.0.noise",
            "p_tar.prior.along",
            "x_obs.noise",
            "avoid.cost.length",
        ),
    ),
    "pusht": Log(
        _double("pusht"),
        lambda: touching(STEPS, ROWS),
        (
            "x_pusher.noise",
            "x_pose.noise",
            "x_pose.measurements.0.noise",
            "x_pose.predict.radius",
            "x_pose.predict.dynamics.body.radius_of_gyration",
            "d_pusher.servo.velocity_by_velocity",
            "p_contact.relation.reach",
        ),
        {"x_pose.predict.friction": 0.2},
    ),
    "pusht, with a noise that grows with the push": Log(
        _double("pusht", push_noise=0.2),
        lambda: touching(STEPS, ROWS),
        ("x_pose.noise.share", "x_pose.noise.rest"),
    ),
    "arm_push": Log(
        _double("arm_push", sensing="pose"),
        _of_the_arm,
        (
            "x_joints.noise",
            "x_pose.noise",
            "x_pose.measurements.0.noise",
            "x_ee.relation.damping",
            "x_ee.relation.pose.length",
            "x_pose.predict.friction",
            "p_contact.relation.reach",
        ),
        {"x_pose.prior.offset": (0.0011, -0.0012, 0.0103)},
    ),
    "reach": Log(
        _double("reach", robot=planar_arm()),
        _of_reach,
        (
            "x_joints.noise",
            "x_joints.measurements.0.noise",
            "x_ee.relation.damping",
            "x_ee.relation.chain.product.constant",
        ),
    ),
    "reach, with a ball": Log(
        _double("reach", robot=planar_arm(), balls=1),
        _of_a_ball,
        ("x_joints.noise", "x_joints.measurements.0.noise"),
    ),
    "a network": Log(
        _seeing,
        lambda: [{"z": 1.0 + normal(ROWS, 2, seed=step)} for step in range(STEPS)],
        ("p.noise", "p.measurements.0"),
    ),
}


def stacked(observations: list[dict[str, Tensor]]) -> dict[str, Tensor]:
    """The observations of T steps as series ``(B, T, n)``."""
    return {key: torch.stack([o[key] for o in observations], dim=-2) for key in observations[0]}


def random_actions(policy: Policy, rows: int = ROWS, steps: int = STEPS) -> dict[str, Tensor]:
    """What was done: a tenth of what can be, ``(B, T, n)``."""
    actions: dict[str, Tensor] = {}
    for seed, (name, actuator) in enumerate(policy.model.actuators.items()):
        limit = actuator.limit_like(policy.model.like)
        actions[name] = 0.1 * limit * normal(rows, steps, actuator.size, seed=seed)
    return actions


def slope_off(function: Callable[[], Tensor], parameter: Tensor, wanted: Tensor) -> float:
    """By how much central differences of sixth order differ from d function / d (1, …, 1)ᵀθ.

    It is a share of the largest of what is wanted, at least of a thousandth. Of several widths that
    which agrees best: too wide a one bends, too narrow a one rounds.
    """
    off, scale = math.inf, max(float(wanted.abs().max()), 1e-3)
    for width in (1e-2, 3e-3, 1e-3, 3e-2, 1e-1, 1e-4, 1e-5):
        slope = torch.zeros_like(wanted)
        for shift, weight in ((1, 45), (2, -9), (3, 1)):
            for side in (-1, 1):
                with torch.no_grad():
                    before = parameter.clone()
                    parameter += side * shift * width
                    slope += side * weight * function() / (60 * width)
                    parameter.copy_(before)
        off = min(off, float((slope - wanted).abs().max()) / scale)
        if off <= AGREES:
            break
    return off
