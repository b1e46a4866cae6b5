"""The graph of worlds in which a gripper picks a block up and places it, without phases.

From the goal to the gripper lead three paths: over the grasp that is to come, over the table that
holds the block back, and over the tip that carries it. Nothing says in which order. What a world
adds is its :class:`Hand`; what is set by hand, :class:`Options`, is the same in all.
"""

import math
from dataclasses import dataclass, field
from typing import Any

import torch
from torch import Tensor

from aicon_torch import (
    EKF,
    Actuator,
    Affine,
    Deterministic,
    Foresight,
    Goal,
    Interconnection,
    Measurement,
    NullspaceProjection,
    Policy,
    Sensor,
    WorldModel,
)
from aicon_torch.control import ActionLaw
from aicon_torch.parts import (
    Carrying,
    Grasp,
    Gripper,
    ReadingPrior,
    approached,
    carried,
    first_belief,
    from_above,
    norm,
)
from aicon_torch.resolution import Resolution, SteepestPath

SIZE = 0.04  # m, of a block
TIP_NOISE = 1e-4  # m, of its reading
LAG = 0.01  # m, by which a motion differs from what it was told
DRIFT = 0.001  # m, of what nothing moves, in a step


@dataclass(frozen=True)
class Hand:
    """What holds a block, and how it is told to move.

    Attributes:
        time_step: s.
        steps: How far an action of 1 moves the tip in a step: x, y and z, and where the fingers
            turn, the way of a point at the block's edge, m.
        widest: Largest opening, m.
        first: The opening at the beginning, m.
        speed: Of the opening, m/s.
        height: Of the tip above the centre of a block that is held, m.
    """

    time_step: float
    steps: tuple[float, ...]
    widest: float
    first: float
    speed: float
    height: float


@dataclass(frozen=True)
class Options:
    """What is set by hand: five lengths, m; and what the readings are worth."""

    reach: float = 0.05  # from where a grasp draws
    step: float = 0.05  # what a motion of the block is taken to be, at most
    rise: float = 0.055  # of the block, at which the table holds it back no more
    tolerance: float = 0.012  # of the place
    free_hand: float = 0.015  # the error of the place that an empty hand outweighs
    noise: float = 0.0005  # of the block's readings
    resolution: Resolution = field(default_factory=NullspaceProjection)
    law: ActionLaw = field(default_factory=Foresight)


PRESETS: dict[str, dict[str, Any]] = {
    "aicon": {},
    "without_exploration": {"resolution.exploration": None},
    "weighted_sum": {"resolution.projector": "none"},
    "steepest": {"resolution": SteepestPath()},
}


def build_policy(hand: Hand, options: Options) -> Policy:
    """The policy of a hand, which reads z_tip and z_block, and z_goal.

    Args:
        hand: The hand; its tip and a block have as many components as it has steps.
        options: What is set by hand.
    """
    size = len(hand.steps)
    gripper = Gripper(narrowest=SIZE / 2, widest=hand.widest, speed=hand.speed, first=hand.first)
    grasp = Grasp(gripper, SIZE, hand.height, options.reach)
    carrying = Carrying(options.step, rest=SIZE / 2, rise=options.rise)

    # 1. What is wanted: the block at its place, and a hand that holds nothing.
    def place(x_obj: Tensor, z_goal: Tensor) -> Tensor:
        beside = x_obj[..., :3] - z_goal
        way = norm(beside - from_above(beside, options.tolerance, options.rise))
        return (way - options.tolerance).clamp(min=0.0).square() / 2

    def free_hand(p_grasp: Tensor) -> Tensor:
        return options.free_hand**2 / 2 * p_grasp[..., 0]

    # 2. What is uncertain: where the block is while it is held, and where the tip is from it while
    # it is not.
    def object_drift(p_held: Tensor) -> Tensor:
        return (DRIFT**2 + (p_held * LAG) ** 2).expand(*p_held.shape[:-1], size)

    def apart_drift(p_held: Tensor) -> Tensor:
        return (DRIFT**2 + ((1 - p_held) * LAG) ** 2).expand(*p_held.shape[:-1], size)

    def first_apart(z_tip: Tensor, z_block: Tensor) -> tuple[Tensor, Tensor]:
        return alike(z_tip - z_block), options.noise**2 * torch.eye(size).to(z_tip)

    def seen_apart(x_rel: Tensor, x_tip: Tensor, x_object: Tensor) -> Tensor:
        return alike(x_rel - x_tip + x_object)

    def position(
        name: str, predict: Any, drift: Any, residual: Any, first: Any, **read: Any
    ) -> EKF:
        return EKF(
            name,
            f"P{name[1:]}",
            predict=predict,
            noise=drift,
            initial=first,
            size=size,
            correct=[Measurement(residual, size=size, **read)],
        )

    def read_first(reading: str) -> Any:
        return first_belief(ReadingPrior((1e-6,) * size), reading)

    tip = position(
        "x_tip",
        Affine(x_tip=1.0, tip="dt"),
        LAG**2,
        Affine(x_tip=1.0, z_tip=-1.0),
        read_first("z_tip"),
        noise=TIP_NOISE**2,
    )
    block = position(
        "x_object",
        Interconnection(carried, ["x_object", "p_held", "tip", "dt"]),
        object_drift,
        Affine(x_object=1.0, z_block=-1.0),
        read_first("z_block"),
        noise=options.noise**2,
    )
    apart = position(
        "x_rel",
        Interconnection(approached, ["x_rel", "p_held", "tip", "dt"]),
        apart_drift,
        seen_apart,
        first_apart,
        noise=TIP_NOISE**2,
        uncertain={"x_tip": "P_tip", "x_object": "P_object"},
    )

    # 3. The graph.
    def command(tip: Tensor) -> Tensor:
        return tip * hand.time_step / tip.new_tensor(hand.steps)

    speeds = tuple(step / hand.time_step for step in hand.steps)
    model = WorldModel(
        sensors={
            "z_tip": Sensor(size, "m"),
            "z_block": Sensor(size, "m"),
            "z_goal": Sensor(3, "m"),
        },
        actuators={
            "tip": Actuator(size, "m/s", limit=speeds, command=command, command_range=(-1.0, 1.0)),
            "jaw": gripper.actuator(),
        },
        estimators=[
            grasp.held(),  # what is first of a circle runs last: held reads the newest x_rel
            gripper,
            tip,
            block,
            apart,
            Deterministic("p_grasp", grasp.likelihood),
            Deterministic("p_free", carrying.free),
            Deterministic("x_obj", carrying),
        ],
        goals=[Goal("place", place), Goal("free hand", free_hand)],
        dt=hand.time_step,
        dtype=torch.float64,
    )
    return Policy(model, options.resolution, options.law)


def alike(offset: Tensor) -> Tensor:
    """An offset ``(*B, n)``, m, whose turn, if it has one, is that to the nearest side of a block.

    A block turned by 90° is like one that is not: a way of rπ/2 at its edge.
    """
    quarter = SIZE / 2 * math.pi / 2
    turn = torch.remainder(offset[..., 3:] + quarter / 2, quarter) - quarter / 2
    return torch.cat((offset[..., :3], turn), dim=-1)
