"""The model "pushing": a hand pushes a round thing over a table, to rest at its goal.

An observation has the hand ``z_hand`` and the goal ``z_goal``, ``(*B, 3)``, m, and of the thing
where it is, ``z_place``, ``(*B, 2)``, m, and how fast, ``v_obj``, ``(*B, 2)``, m/s. The actions are
the hand's velocity over the table, ``a``, and up, ``lift``: the hand stays as high as the goal.

From the goal to the hand leads one path over the push, and one over the contact that is to come.
Nothing says in which order. What a world adds is its :class:`Hand` and the thing,
:class:`~aicon_torch.parts.RoundObject`.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import torch
from torch import Tensor

from aicon_torch.control import ActionLaw, DirectDescent, Foresight
from aicon_torch.estimation import Deterministic
from aicon_torch.goals import Goal
from aicon_torch.graph import WorldModel
from aicon_torch.interconnections import Affine, Interconnection
from aicon_torch.parts.commands import DisplacementCommand
from aicon_torch.parts.planar import norm
from aicon_torch.parts.round_object import RoundObject
from aicon_torch.policy import Policy
from aicon_torch.quantities import Actuator, Sensor
from aicon_torch.resolution import NullspaceProjection, Resolution, SteepestPath


@dataclass(frozen=True)
class Hand:
    """What is told how far to go in a step, and goes there at once.

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
    """What is set by hand.

    Attributes:
        size: Of which the ranges of a contact are shares
            (:class:`~aicon_torch.parts.ContactOptions`), m.
        tolerance: Of the place to which the thing is pushed, m.
        resolution: How gradients that meet are resolved.
        law: How the gradient becomes an action.
    """

    size: float = 0.4
    tolerance: float = 0.03
    resolution: Resolution = field(default_factory=NullspaceProjection)
    law: ActionLaw = field(default_factory=Foresight)


PRESETS: Mapping[str, Mapping[str, Any]] = {
    "aicon": {},
    "without_exploration": {"resolution.exploration": None},
    "weighted_sum": {"resolution.projector": "none"},
    "without_foresight": {"law": DirectDescent()},
    "steepest": {"resolution": SteepestPath()},
}
"""Options by preset: ours, ours without exploration, a sum that explores, ours without looking
ahead, and the steepest path."""

DEFAULTS = Options()


def build_policy(hand: Hand, thing: RoundObject, options: Options = DEFAULTS) -> Policy:
    """The policy of a hand.

    Args:
        hand: The hand.
        thing: What it pushes.
        options: What is set by hand.
    """
    return Policy(world_model(hand, thing, options), options.resolution, options.law)


def world_model(hand: Hand, thing: RoundObject, options: Options = DEFAULTS) -> WorldModel:
    """The graph of a hand and of what it pushes."""
    level, up = torch.eye(3)[:2], torch.eye(3)[2:]

    def far(x_obj: Tensor, z_goal: Tensor) -> Tensor:
        return norm(x_obj - z_goal[..., :2])

    def high(p_height: Tensor, z_goal: Tensor) -> Tensor:
        return norm(p_height - z_goal[..., 2:])

    sizes = {"z_hand": 3, "z_goal": 3, "z_place": 2, "v_obj": 2}
    return WorldModel(
        sensors={name: Sensor(size, "SI") for name, size in sizes.items()},
        actuators={"a": hand.actuator("a", 2), "lift": hand.actuator("lift", 1)},
        estimators=[
            Deterministic("d_pusher", Affine(a="dt")),
            Deterministic("x_pusher", Affine(z_hand=level, d_pusher=1.0)),
            Deterministic("p_height", Affine(z_hand=up, lift="dt")),
            *thing.estimators(),
        ],
        goals=[Goal("push", far, tolerance=options.tolerance), Goal("low", high)],
        dt=hand.time_step,
        dtype=torch.float64,
    )
