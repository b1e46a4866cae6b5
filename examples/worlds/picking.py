"""The graph of worlds in which a gripper picks a block up and places it, without phases.

From the goal to the gripper lead three paths: over the grasp that is to come, over the table that
holds the block back, and over the tip that carries it. Nothing says in which order. What a world
adds is its :class:`Hand`; what is set by hand, :class:`Options`, is the same in all.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import torch
from torch import Tensor

from aicon_torch import (
    EKF,
    Actuator,
    Affine,
    Deterministic,
    Estimator,
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
from aicon_torch.estimation import covariance_name
from aicon_torch.parts import (
    Carrying,
    Grasp,
    Gripper,
    Handle,
    ReadingPrior,
    Room,
    approached,
    carried,
    first_belief,
    way_from_above,
    worth_of_room,
)
from aicon_torch.parts.planar import norm
from aicon_torch.resolution import Resolution, SteepestPath
from aicon_torch.shaping import straight_through

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
    """What is set by hand: four lengths, m; and what is known of blocks and their readings, m."""

    reach: float = 0.05  # from where a grasp draws, and how far it is taken to bring a block
    rise: float = 0.055  # of the block, at which the table holds it back no more
    tolerance: float = 0.012  # of the place
    free_hand: float = 0.015  # the error of the place that an empty hand outweighs
    noise: float = 0.0005  # of the block's readings
    size: float = SIZE  # width and height of a block
    clearance: float | None = None  # above a block, where nothing stands in the way; its own height
    blocks: int = 1  # how many there are
    resolution: Resolution = field(default_factory=NullspaceProjection)
    law: ActionLaw = field(default_factory=Foresight)

    @property
    def height(self) -> float:
        """How far a block is lifted that is carried, m."""
        return max(self.rise, self.clearance or 0.0)


@dataclass(frozen=True)
class Surroundings:
    """What else is in a world than blocks and a hand.

    Attributes:
        sensors: What is read of it.
        goals: What else is wanted.
        estimators: What else is known.
        moved_by: What moves the tip, where it is told otherwise than how far to go; its velocity,
            tip, is then one of the estimators.
        handles: What else can be held, by what the names of its quantities end with. Read are where
            it is, z_block, and how far from its first end, z_way; p_free, of the estimators, says
            how likely it is unlocked.
        has_drawer: Whether x_place and p_room, of the estimators, say where the block belongs and
            how likely that can be come to.
    """

    sensors: Mapping[str, Sensor] = field(default_factory=dict)
    goals: Sequence[Goal] = ()
    estimators: Sequence[Estimator] = ()
    moved_by: Mapping[str, Actuator] = field(default_factory=dict)
    handles: Mapping[str, Handle] = field(default_factory=dict)
    has_drawer: bool = False


PRESETS: dict[str, dict[str, Any]] = {
    "aicon": {},
    "without_exploration": {"resolution.exploration": None},
    "weighted_sum": {"resolution.projector": "none"},
    "steepest": {"resolution": SteepestPath()},
}


def build_policy(hand: Hand, options: Options, around: Surroundings = Surroundings()) -> Policy:
    """The policy of a hand, which reads z_tip, and z_block and z_goal of each block.

    Args:
        hand: The hand; its tip and a block have as many components as it has steps.
        options: What is set by hand.
        around: What else is in the world.
    """
    size = len(hand.steps)
    grasp = grasp_of(hand, options)
    gripper, names = grasp.gripper, block_names(options.blocks)

    tip = position(
        "x_tip",
        Affine(x_tip=1.0, tip="dt"),
        LAG**2,
        Affine(x_tip=1.0, z_tip=-1.0),
        read_first("z_tip", size),
        size=size,
        noise=TIP_NOISE**2,
    )

    def command(tip: Tensor) -> Tensor:
        return tip * hand.time_step / tip.new_tensor(hand.steps)

    speeds = tuple(step / hand.time_step for step in hand.steps)
    told = {"tip": Actuator(size, "m/s", limit=speeds, command=command, command_range=(-1.0, 1.0))}
    sensors = {"z_tip": Sensor(size, "m"), **around.sensors}
    goals = list(around.goals)
    blocks: list[Estimator] = []
    rooms: list[Estimator] = []
    things = [*names, *around.handles]
    for name in names:
        others = [other for other in names if other != name]
        sensors |= {f"z_block{name}": Sensor(size, "m"), f"z_goal{name}": Sensor(3, "m")}
        goals += wishes(name, others, options, around)
        if others:
            read = [f"z_goal{name}"]
            for other in others:
                read += [f"x_obj{other}", f"z_goal{other}"]
            rest, slack = options.size / 2, options.tolerance
            room = Room(options.size, rest, slack, clearance=options.rise)
            among = Interconnection(room, read)
            rooms.append(Deterministic(f"p_room{name}", among))
    for name in around.handles:
        sensors |= {f"z_block{name}": Sensor(size, "m"), f"z_way{name}": Sensor(1, "m")}
    for name in things:
        others = [other for other in things if other != name]
        blocks += block(name, others, size, grasp, options, around.handles.get(name))

    # What is first of a circle runs last: held reads the newest x_rel.
    held = [grasp.held(name, by_open_fingers=name in around.handles) for name in things]
    model = WorldModel(
        sensors=sensors,
        actuators={**(around.moved_by or told), "jaw": gripper.actuator()},
        estimators=[*held, gripper, tip, *blocks, *rooms, *around.estimators],
        goals=goals,
        dt=hand.time_step,
        dtype=torch.float64,
    )
    return Policy(model, options.resolution, options.law)


def grasp_of(hand: Hand, options: Options) -> Grasp:
    """How a hand comes to hold a block."""
    narrowest = options.size / 2
    gripper = Gripper(narrowest, widest=hand.widest, speed=hand.speed, first=hand.first)
    return Grasp(gripper, options.size, hand.height, options.reach, options.clearance)


def block_names(count: int) -> list[str]:
    """What the names of each block's quantities end with; of a single one, with nothing."""
    return [""] if count == 1 else [f"_{number}" for number in range(count)]


def wishes(name: str, others: list[str], options: Options, around: Surroundings) -> list[Goal]:
    """What is wanted of a block: at its place, and in no hand.

    Its cost is that of its distance ‖Δ‖, whose gradient leads by the way from above.

    Args:
        name: What its quantities' names end with.
        others: What those of the other blocks end with.
        options: What is set by hand.
        around: What else is in the world.
    """

    def place(x_obj: Tensor, z_goal: Tensor) -> Tensor:
        offset = x_obj[..., :3] - z_goal
        from_above = way_from_above(offset, options.tolerance, options.height)
        way = straight_through(norm(offset), from_above)
        return (way - options.tolerance).clamp(min=0.0).square() / 2

    def place_among_others(x_obj: Tensor, z_goal: Tensor, p_room: Tensor) -> Tensor:
        return worth_of_room(place(x_obj, z_goal), p_room)

    read = [f"x_obj{name}", f"x_place{name}" if around.has_drawer else f"z_goal{name}"]
    placed = Interconnection(place, read)
    if others or around.has_drawer:
        placed = Interconnection(place_among_others, [*read, f"p_room{name}"])
    return [Goal(f"place{name}", placed), free_hand(name, options)]


def free_hand(name: str, options: Options) -> Goal:
    """The wish that no hand holds a thing, which counts as much as an error of its place."""

    def held(p_grasp: Tensor) -> Tensor:
        return options.free_hand**2 / 2 * p_grasp[..., 0]

    return Goal(f"free hand{name}", Interconnection(held, [f"p_grasp{name}"]))


def block(
    name: str,
    others: list[str],
    size: int,
    grasp: Grasp,
    options: Options,
    handle: Handle | None = None,
) -> list[Estimator]:
    """What is known of a block, or of a handle, and what may move it.

    Uncertain is where it is while it is held, and where the tip is from it while it is not.

    Args:
        name: What its quantities' names end with.
        others: What those of all else that can be held end with.
        size: How many components its place has.
        grasp: How it comes to be held.
        options: What is set by hand.
        handle: How it moves, where it is a handle.
    """
    x_object, x_rel, z_block = f"x_object{name}", f"x_rel{name}", f"z_block{name}"
    p_grasp, p_held, p_free = f"p_grasp{name}", f"p_held{name}", f"p_free{name}"
    carrying = Carrying(options.reach, rest=options.size / 2, rise=options.height)
    moved, goes, comes, side = carrying, carried, approached, options.size
    if handle is not None:
        # A bar is alike after half a turn, a block after a quarter.
        moved, goes, comes, side = handle, handle.carried, handle.approached, 2 * options.size

    # 1. How each drifts, and what is known at first.
    def object_drift(p_held: Tensor) -> Tensor:
        return (DRIFT**2 + (p_held * LAG) ** 2).expand(*p_held.shape[:-1], size)

    def apart_drift(p_held: Tensor) -> Tensor:
        return (DRIFT**2 + ((1 - p_held) * LAG) ** 2).expand(*p_held.shape[:-1], size)

    def first_apart(z_tip: Tensor, z_block: Tensor) -> tuple[Tensor, Tensor]:
        return alike(z_tip - z_block, side), options.noise**2 * torch.eye(size).to(z_tip)

    def seen_apart(x_rel: Tensor, x_tip: Tensor, x_object: Tensor) -> Tensor:
        return alike(x_rel - x_tip + x_object, side)

    # 2. Where it is, and where the tip is from it.
    where = position(
        x_object,
        Interconnection(goes, [x_object, p_held, "tip", "dt"]),
        Interconnection(object_drift, [p_held]),
        Affine(**{x_object: 1.0, z_block: -1.0}),
        read_first(z_block, size),
        size=size,
        noise=options.noise**2,
    )
    apart = position(
        x_rel,
        Interconnection(comes, [x_rel, p_held, "tip", "dt"]),
        Interconnection(apart_drift, [p_held]),
        Interconnection(seen_apart, [x_rel, "x_tip", x_object]),
        Interconnection(first_apart, ["z_tip", z_block]),
        size=size,
        noise=TIP_NOISE**2,
        uncertain={"x_tip": "P_tip", x_object: covariance_name(x_object)},
    )

    # 3. What may move it; a hand that has another between its fingers comes to hold no more.
    grasped_by = [x_rel, "x_opening", *(f"x_rel{other}" for other in others)]
    moved_by = [x_object, "x_tip", p_grasp, p_held, p_free]
    if handle is not None:
        moved_by.append(f"z_way{name}")
    estimators = [
        where,
        apart,
        Deterministic(p_grasp, Interconnection(grasp.likelihood, grasped_by)),
        Deterministic(f"x_obj{name}", Interconnection(moved, moved_by)),
    ]
    if handle is None:
        estimators.insert(3, Deterministic(p_free, Interconnection(carrying.free, [x_object])))
    return estimators


def position(
    name: str, predict: Any, drift: Any, residual: Any, first: Any, *, size: int, **read: Any
) -> EKF:
    """The filter of a position, which is read once a step."""
    return EKF(
        name,
        covariance_name(name),
        predict=predict,
        noise=drift,
        initial=first,
        size=size,
        correct=[Measurement(residual, size=size, **read)],
    )


def read_first(reading: str, size: int) -> Any:
    """The first belief is the first reading."""
    return first_belief(ReadingPrior((1e-6,) * size), reading)


def alike(offset: Tensor, width: float) -> Tensor:
    """An offset ``(*B, n)``, m, whose turn, if it has one, is that to the nearest side of a block.

    A block turned by 90° is like one that is not: a way of rπ/2 at its edge.
    """
    quarter = width / 2 * math.pi / 2
    turn = torch.remainder(offset[..., 3:] + quarter / 2, quarter) - quarter / 2
    return torch.cat((offset[..., :3], turn), dim=-1)
