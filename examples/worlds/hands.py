"""Hands that are told how far to go: the graph of one that reaches a place, and their tasks.

What a world adds is its :class:`Hand`; what is set by hand, :class:`Options`, is the same in all.
One that pushes a thing has the library's graph, :mod:`aicon_torch.models.pushing`.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import gymnasium
import torch
from torch import Tensor

from aicon_baselines.evaluation.task import Task
from aicon_baselines.tasks.side_by_side import side_by_side
from aicon_torch import Affine, Deterministic, Goal, Policy, Sensor, WorldModel
from aicon_torch.models import pushing
from aicon_torch.models.pushing import PRESETS, Hand
from aicon_torch.parts import norm

__all__ = ["PRESETS", "Hand", "Options", "hand_task", "reach_policy"]


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


def hand_task(
    name: str,
    time_step: float,
    horizon: int,
    conditions: tuple[str, ...],
    presets: Iterable[str],
    world: Callable[..., gymnasium.Env[Any, Any]],
) -> Task:
    """The task of a world, whose module has its name.

    Args:
        name: Of the module.
        time_step: Of the policy, s.
        horizon: Steps of an episode.
        conditions: What there is to do.
        presets: Names of its policies.
        world: Makes one for a condition and options of its own.
    """

    def make_env(count: int, condition: str, horizon: int, **options: Any) -> Any:
        return side_by_side(lambda: world(condition, **options), count, horizon)

    return Task(
        name=name,
        time_step=time_step,
        horizon=horizon,
        chunk_size=50,
        maps=("table",),
        conditions=conditions,
        make_env=make_env,
        policy_options=policy_options,
        noiseless=conditions,
        time_unit="steps",
        model=name,
        presets=tuple(presets),
    )
