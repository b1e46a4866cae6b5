"""The graph of a gripper that picks blocks up and places them, without phases.

An observation has the tip ``z_tip``, and of each block where it is, ``z_block``, and where it
belongs, ``z_goal``, m. The actions are the velocity of the tip and the opening of the jaw.

From the goal to the gripper lead three paths: over the grasp that is to come, over the table that
holds the block back, and over the tip that carries it. Nothing says in which order. What a world
adds is its :class:`Hand`; what is set by hand, :class:`Options`, is the same in all.
"""

import math
from collections.abc import Callable
from typing import Any

import torch
from torch import Tensor

from aicon_torch.differentiation import stop
from aicon_torch.estimation import EKF, Deterministic, Estimator, Measurement, covariance_name
from aicon_torch.goals import Goal
from aicon_torch.graph import WorldModel
from aicon_torch.interconnections import Affine, Interconnection
from aicon_torch.models.picking.options import Hand, Options, Surroundings
from aicon_torch.parts.grasp import Carrying, Grasp, Held, approached, carried, way_from_above
from aicon_torch.parts.gripper import Gripper
from aicon_torch.parts.handle import Handle
from aicon_torch.parts.planar import norm
from aicon_torch.parts.prior import ReadingPrior, first_belief
from aicon_torch.parts.room import Room, worth_of_room
from aicon_torch.policy import Policy
from aicon_torch.quantities import Sensor
from aicon_torch.shaping import straight_through

TIP_NOISE = 1e-4
"""Deviation of the tip's reading, m."""

LAG = 0.01
"""By which a motion differs from what it was told, m."""

DRIFT = 0.001
"""Of what nothing moves, in a step, m."""

DEFAULTS, NOTHING_ELSE = Options(), Surroundings()


def build_policy(
    hand: Hand, options: Options = DEFAULTS, around: Surroundings = NOTHING_ELSE
) -> Policy:
    """The policy of a hand.

    Args:
        hand: The hand; its tip and a block have as many components as it has steps.
        options: What is set by hand.
        around: What else is in the world.
    """
    return Policy(world_model(hand, options, around), options.resolution, options.law)


def world_model(
    hand: Hand, options: Options = DEFAULTS, around: Surroundings = NOTHING_ELSE
) -> WorldModel:
    """The graph of a hand, of each block, and of each handle."""
    size, grasp = len(hand.steps), grasp_of(hand, options)
    names = block_names(options.blocks)
    things = [*names, *around.handles]

    sensors = {"z_tip": Sensor(size, "m"), **around.sensors}
    goals = list(around.goals)
    rooms: list[Estimator] = []
    for name in names:
        others = [other for other in names if other != name]
        sensors |= {f"z_block{name}": Sensor(size, "m"), f"z_goal{name}": Sensor(3, "m")}
        goals += wishes(name, others, options, around)
        if others:
            rooms.append(room_among(name, others, options))
    for name in around.handles:
        sensors |= {f"z_block{name}": Sensor(size, "m"), f"z_way{name}": Sensor(1, "m")}

    # What is first of a circle runs last: held reads the newest x_rel.
    estimators: list[Estimator] = [
        *(Held(grasp, name, by_open_fingers=name in around.handles) for name in things),
        grasp.gripper,
        tip(size),
    ]
    for name in things:
        others = [other for other in things if other != name]
        estimators += block(name, others, size, grasp, options, around.handles.get(name))
    return WorldModel(
        sensors=sensors,
        actuators={
            **(around.moved_by or {"tip": hand.actuator()}),
            "jaw": grasp.gripper.actuator(),
        },
        estimators=[*estimators, *rooms, *around.estimators],
        goals=goals,
        dt=hand.time_step,
        dtype=torch.float64,
    )


def tip(size: int) -> EKF:
    """x_tip: it goes as it is told, and is read."""
    return position(
        "x_tip",
        Affine(x_tip=1.0, tip="dt"),
        LAG**2,
        Affine(x_tip=1.0, z_tip=-1.0),
        read_first("z_tip", size),
        size=size,
        noise=TIP_NOISE**2,
    )


def room_among(name: str, others: list[str], options: Options) -> Deterministic:
    """p_room: how likely the place of a block takes it, by where the others are and belong."""
    room = Room(options.size, options.rest, options.tolerance, clearance=options.rise)
    read = [f"z_goal{name}"]
    for other in others:
        read += [f"x_obj{other}", f"z_goal{other}"]
    return Deterministic(f"p_room{name}", Interconnection(room, read))


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
    x_object, x_rel = f"x_object{name}", f"x_rel{name}"
    p_grasp, p_held, p_free = f"p_grasp{name}", f"p_held{name}", f"p_free{name}"
    carrying = Carrying(options.reach, rest=options.rest, rise=options.height)

    # 1. Where it is, and where the tip is from it: a bar is alike after half a turn, a block after
    # a quarter.
    goes, comes, side = carried, approached, options.size
    if handle is not None:
        goes, comes, side = handle.carried, handle.approached, 2 * options.size
    known = [place_of(name, goes, size, options), tip_from(name, comes, size, options, side)]

    # 2. How likely it comes to be held; a hand that is about another comes to hold no more.
    grasped_by = [x_rel, "x_opening", *(f"x_rel{other}" for other in others)]
    grasped = Deterministic(p_grasp, Interconnection(grasp.likelihood, grasped_by))

    # 3. What may move it: a block that is free of the table, a handle that is unlocked.
    moved_by = [x_object, "x_tip", p_grasp, p_held, p_free]
    if handle is None:
        free = Deterministic(p_free, Interconnection(carrying.free, [x_object]))
        moves: Callable[..., Tensor] = carrying if options.grasp_path else without_grasp(carrying)
        moved = Deterministic(f"x_obj{name}", Interconnection(moves, moved_by))
        return [*known, grasped, free, moved]
    moved = Deterministic(f"x_obj{name}", Interconnection(handle, [*moved_by, f"z_way{name}"]))
    return [*known, grasped, moved]


def without_grasp(carrying: Carrying) -> Callable[..., Tensor]:
    """What moves a block that is held already: no path leads over the grasp that is to come."""

    def moves(
        x_object: Tensor, x_tip: Tensor, p_grasp: Tensor, p_held: Tensor, p_free: Tensor
    ) -> Tensor:
        return carrying(x_object, x_tip, stop(p_grasp), p_held, p_free)  # stops that path

    return moves


def place_of(name: str, goes: Any, size: int, options: Options) -> EKF:
    """x_object: where a thing is, which drifts while it is held; ``goes`` says how it moves."""
    x_object, p_held, z_block = f"x_object{name}", f"p_held{name}", f"z_block{name}"

    def drift(p_held: Tensor) -> Tensor:
        return (DRIFT**2 + (p_held * LAG) ** 2).expand(*p_held.shape[:-1], size)

    return position(
        x_object,
        Interconnection(goes, [x_object, p_held, "tip", "dt"]),
        Interconnection(drift, [p_held]),
        Affine(**{x_object: 1.0, z_block: -1.0}),
        read_first(z_block, size),
        size=size,
        noise=options.noise**2,
    )


def tip_from(name: str, comes: Any, size: int, options: Options, side: float) -> EKF:
    """x_rel: where the tip is from a thing, which drifts while it is not held.

    Args:
        name: What its quantities' names end with.
        comes: How it changes as the tip moves.
        size: How many components its place has.
        options: What is set by hand.
        side: Its width: after a quarter of a turn about it, it is alike, m.
    """
    x_object, x_rel, p_held = f"x_object{name}", f"x_rel{name}", f"p_held{name}"

    def drift(p_held: Tensor) -> Tensor:
        return (DRIFT**2 + ((1 - p_held) * LAG) ** 2).expand(*p_held.shape[:-1], size)

    def predict(x_rel: Tensor, p_held: Tensor, tip: Tensor, dt: Tensor) -> Tensor:
        return alike(comes(x_rel, p_held, tip, dt), side)

    def first(z_tip: Tensor, z_block: Tensor) -> tuple[Tensor, Tensor]:
        return alike(z_tip - z_block, side), options.noise**2 * torch.eye(size).to(z_tip)

    def residual(x_rel: Tensor, x_tip: Tensor, x_object: Tensor) -> Tensor:
        return alike(x_rel - x_tip + x_object, side)

    return position(
        x_rel,
        Interconnection(predict, [x_rel, p_held, "tip", "dt"]),
        Interconnection(drift, [p_held]),
        Interconnection(residual, [x_rel, "x_tip", x_object]),
        Interconnection(first, ["z_tip", f"z_block{name}"]),
        size=size,
        noise=TIP_NOISE**2,
        uncertain={"x_tip": "P_tip", x_object: covariance_name(x_object)},
    )


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
