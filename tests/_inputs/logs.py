"""Logs of the shipped models: what was read and done, and which of their numbers learn."""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import torch
from torch import Tensor

from _inputs.arm import HOME
from _inputs.navigation import drifting
from _inputs.pushing import wandering
from _inputs.random_numbers import normal
from _inputs.reaching import planar_arm
from _inputs.shipped import lean
from aicon_torch import Policy

STEPS, ROWS = 11, 2


class Log(NamedTuple):
    """A policy, what it read step by step, and the names of numbers of each kind."""

    make: Callable[[], Policy]
    observations: Callable[[], list[dict[str, Tensor]]]
    numbers: tuple[str, ...]


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


def _double(name: str, **options: Any) -> Callable[[], Policy]:
    return lambda: lean(name, dtype=torch.float64, **options)


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
        lambda: wandering(STEPS, ROWS),
        (
            "x_pusher.noise",
            "x_pose.noise",
            "x_pose.measurements.0.noise",
            "x_pose.predict.radius",
            "x_pose.predict.dynamics.body.radius_of_gyration",
            "p_contact.relation.reach",
        ),
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
            "p_contact.relation.reach",
        ),
    ),
    "reach": Log(
        _double("reach", robot=planar_arm()),
        _of_reach,
        ("x_joints.noise", "x_joints.measurements.0.noise"),
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
    for width in (1e-2, 3e-3, 1e-3, 3e-2, 1e-1, 1e-4):
        slope = torch.zeros_like(wanted)
        for shift, weight in ((1, 45), (2, -9), (3, 1)):
            for side in (-1, 1):
                with torch.no_grad():
                    before = parameter.clone()
                    parameter += side * shift * width
                    slope += side * weight * function() / (60 * width)
                    parameter.copy_(before)
        off = min(off, float((slope - wanted).abs().max()) / scale)
        if off <= 1e-7:
            break
    return off
