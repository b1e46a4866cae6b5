"""Hands that are told how far to go: the graph of one that reaches a place.

What a world adds is its :class:`Hand`; what is set by hand, :class:`Options`, is the same in all.
One that pushes a thing has the library's graph, :mod:`aicon_torch.models.pushing`.
"""

from dataclasses import dataclass
from typing import Any

import torch
from torch import Tensor

from aicon_torch import Affine, Deterministic, Goal, Policy, Sensor, WorldModel
from aicon_torch.models import pushing
from aicon_torch.models.pushing import PRESETS, Hand
from aicon_torch.parts import norm

__all__ = ["PRESETS", "Hand", "Options", "policy_options", "reach_policy"]


@dataclass(frozen=True)
class Options(pushing.Options):
    """What is set by hand, and what there is to do."""

    task: str = "reach"


def reach_policy(hand: Hand, options: Options) -> Policy:
    """The hand goes to z_goal, from z_hand."""

    def far(p_hand: Tensor, z_goal: Tensor) -> Tensor:
        return norm(p_hand - z_goal)

    model = WorldModel(
        sensors={name: Sensor(3, "m") for name in ("z_hand", "z_goal")},
        actuators={"a": hand.actuator("a", 3)},
        estimators=[Deterministic("p_hand", Affine(z_hand=1.0, a="dt"))],
        goals=[Goal("reach", far)],
        dt=hand.time_step,
        dtype=torch.float64,
    )
    return Policy(model, options.resolution, options.law)


def policy_options(condition: str) -> dict[str, Any]:
    """What is to be done."""
    return {"task": condition}
