"""The graphs of hands that are told how far to go: to reach a place, and to push a thing to one.

What a world adds is its :class:`Hand`; what is set by hand, :class:`Options`, is the same in all.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Any

import gymnasium
import torch
from torch import Tensor

from aicon_baselines.evaluation.task import Task
from aicon_baselines.tasks.side_by_side import side_by_side
from aicon_torch import (
    Actuator,
    Affine,
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
from aicon_torch.parts import DisplacementCommand, Lag, RoundObject, norm
from aicon_torch.resolution import Resolution, SteepestPath


@dataclass(frozen=True)
class Hand:
    """What is told to go.

    Attributes:
        time_step: s.
        stride: How far a command of 1 brings it in a step, m.
    """

    time_step: float
    stride: float

    def actuator(self, name: str, size: int) -> Actuator:
        """Its velocity in some directions, sent as a displacement."""
        command = Interconnection(DisplacementCommand(self.stride), [name, "dt"])
        speed = self.stride / self.time_step
        return Actuator(size, "m/s", limit=speed, command=command, command_range=(-1.0, 1.0))


@dataclass(frozen=True)
class Options:
    """What is set by hand."""

    task: str = "reach"  # what there is to do
    size: float = 0.4  # of which the ranges of a contact are shares, m
    tolerance: float = 0.03  # of the place to which a thing is pushed, m
    resolution: Resolution = field(default_factory=NullspaceProjection)
    law: ActionLaw = field(default_factory=Foresight)


PRESETS: dict[str, dict[str, Any]] = {
    "aicon": {},
    "without_exploration": {"resolution.exploration": None},
    "weighted_sum": {"resolution.projector": "none"},
    "without_foresight": {"law": DirectDescent()},
    "steepest": {"resolution": SteepestPath()},
}


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


def push_policy(hand: Hand, lag: Lag, body: RoundObject, options: Options) -> Policy:
    """The hand pushes a thing at z_place, moving at v_obj, so that it comes to rest at z_goal."""
    level = torch.eye(3)[:2]

    def way(a: Tensor, v_hand: Tensor, dt: Tensor) -> Tensor:
        return lag.displacement(a, v_hand[..., :2], dt)

    def low(z_hand: Tensor, v_hand: Tensor, lift: Tensor, dt: Tensor) -> Tensor:
        return z_hand[..., 2:] + lag.displacement(lift, v_hand[..., 2:], dt)

    def far(x_obj: Tensor, z_goal: Tensor) -> Tensor:
        return norm(x_obj - z_goal[..., :2])

    def high(p_height: Tensor, z_goal: Tensor) -> Tensor:
        return norm(p_height - z_goal[..., 2:])

    sizes = {"z_hand": 3, "v_hand": 3, "z_place": 2, "v_obj": 2, "z_goal": 3}
    model = WorldModel(
        sensors={name: Sensor(size, "SI") for name, size in sizes.items()},
        actuators={"a": hand.actuator("a", 2), "lift": hand.actuator("lift", 1)},
        estimators=[
            Deterministic("d_pusher", way),
            Deterministic("x_pusher", Affine(z_hand=level, d_pusher=1.0)),
            Deterministic("p_height", low),
            *body.estimators(),
        ],
        goals=[Goal("push", far, tolerance=options.tolerance), Goal("low", high)],
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
