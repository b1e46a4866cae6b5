"""What no part can be built with is named, and is not found out while a robot moves."""

import math
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import pytest
import torch
from _inputs.arm import panda, panda_chain

from aicon_torch.errors import AiconError
from aicon_torch.models.arm_push import PANDA
from aicon_torch.parts import (
    Approach,
    Arrive,
    BearingPrior,
    Capsule,
    Capsules,
    Carrying,
    Chain,
    Clearance,
    ClearanceLimits,
    CollisionLikelihood,
    ContactOptions,
    EndEffector,
    ForceThreshold,
    Grasp,
    Gripper,
    Handle,
    Joint,
    MovingObstacle,
    PlanarDither,
    PoseDistance,
    PoseMotion,
    PoseReach,
    RigidObject,
    Robot,
    Room,
    Servo,
    SquaredHinge,
    Table,
    TipPose,
    ToolAxis,
    ToolPose,
    VelocityLag,
    Walls,
    moving_point,
)

ARM, WALLS, TIP = panda(), Walls(((0.0, 0.0, 1.0, 0.0),)), TipPose("full")
GRIPPER = Gripper(narrowest=0.02, widest=0.12, speed=0.3)
SQUARE = RigidObject.of([(0.0, 0.0), (0.1, 0.0), (0.1, 0.1), (0.0, 0.1)])
DYNAMICS = ContactOptions(size=0.1).dynamics(SQUARE)
PERSON = MovingObstacle("x", "z", 0.1, 0.1, 0.1, dt=0.1)
IDENTITY = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]


POSITIVE: list[tuple[Callable[..., Any], Mapping[str, float]]] = [
    (partial(Approach, panda_chain(), TIP), {"speed": 1.0}),
    (partial(Arrive, ARM), {"time": 0.2}),
    (partial(PlanarDither, ARM), {"speed": 0.4}),
    (partial(ToolAxis, TIP), {"within": 0.1}),
    (partial(EndEffector, ARM.chain, ARM.pose), {"turns_within": 0.1}),
    (TipPose, {"lever": 0.2}),
    (partial(ToolPose, 0.3), {"lever": 0.2}),
    (CollisionLikelihood, {"length": 0.04}),
    (WALLS.collision_likelihood, {"length": 0.04}),
    (partial(PERSON.collision_likelihood, radius=0.1, horizon=1.0), {"length": 0.1}),
    (partial(ClearanceLimits, margin=0.04), {"time": 0.2, "slowest": 0.05}),
    (partial(ForceThreshold, 1.0), {"width": 0.2}),
    (PoseDistance, {"rotation_length": 0.1}),
    (partial(Carrying, rest=0.02), {"step": 0.05, "rise": 0.05}),
    (partial(Gripper, 0.02, 0.12), {"speed": 0.3}),
    (partial(VelocityLag, 3), {"time_constant": 0.1}),
    (partial(moving_point, "x", "z"), {"dt": 0.1, "noise": 0.1, "acceleration": 1.0, "speed": 1.0}),
    (Servo.of, {"stiffness": 100.0, "substep": 0.01}),
]

NOT_NEGATIVE: list[tuple[Callable[..., Any], Mapping[str, float]]] = [
    (partial(EndEffector, ARM.chain, ARM.pose), {"damping": 0.02}),
    (partial(ToolPose, lever=0.2), {"length": 0.3}),
    (partial(PERSON.collision_likelihood, length=0.1), {"radius": 0.1, "horizon": 1.0}),
    (partial(ClearanceLimits, 0.2, slowest=0.05), {"margin": 0.04, "offset": 0.0}),
    (BearingPrior, {"distance": 5.0, "across": 0.1, "along": 1.0}),
    (partial(Walls, WALLS.faces), {"radius": 0.1, "thickness": 0.1}),
    (partial(PoseMotion, DYNAMICS), {"radius": 0.1, "friction": 0.2}),
    (partial(PoseReach, TIP), {"tolerance": 0.001}),
    (partial(Room, 0.04, 0.02, clearance=0.1), {"slack": 0.01}),
    (partial(Gripper, widest=0.12, speed=0.3, first=0.1), {"narrowest": 0.02}),
]

COUNTS: list[tuple[Callable[..., Any], Mapping[str, float]]] = [
    (partial(Clearance, "x_obs", "z_obs", 0.1, 0.1, 0.1), {"delay": 2}),
    (partial(VelocityLag, time_constant=0.1), {"joints": 3}),
    (Servo.of, {"substeps": 10}),
    (partial(moving_point, "x", "z", 0.1), {"size": 2}),
]


@pytest.mark.parametrize(
    ("part", "numbers", "wrong"),
    [
        *((*row, (0.0, -1.0, math.nan, "a", None)) for row in POSITIVE),
        *((*row, (-1.0, math.nan, math.inf, "a")) for row in NOT_NEGATIVE),
        *((*row, (-1, 1.5, "a", None)) for row in COUNTS),
    ],
)
def test_a_number_that_it_may_not_be_is_named(
    part: Callable[..., Any], numbers: Mapping[str, Any], wrong: tuple[Any, ...]
) -> None:
    part(**numbers)
    for name in numbers:
        for value in wrong:
            if name == "turns_within" and value is None:  # all turns count alike
                continue
            with pytest.raises(AiconError, match=f"{name}[ =]"):
                part(**{**numbers, name: value})


@pytest.mark.parametrize("axis", [(0.0, 0.0, 2.0), (1.0, 0.0), (math.nan, 0.0, 1.0), "z", None])
def test_an_axis_is_a_unit_vector(axis: Any) -> None:
    for part in (
        lambda: TipPose("axis", axis=axis),
        lambda: Handle(0.05, axis, travel=0.2),
        lambda: Chain([IDENTITY], IDENTITY, [Joint("elbow", axis)]),
    ):
        with pytest.raises(AiconError, match="axis="):
            part()


def test_a_chain_has_joints_transforms_and_ranges() -> None:
    with pytest.raises(AiconError, match="fixed: got no transform"):
        Chain([], IDENTITY)
    for transform in (
        [[1.0, 0.0], [0.0, 1.0]],
        IDENTITY[:2],
        [[math.nan] * 4] * 3,
        [["a"] * 4] * 3,
    ):
        with pytest.raises(AiconError, match="expected 3 rows of 4 finite numbers"):
            Chain([IDENTITY], transform)
    for low, high in ((1.0, -1.0), (0.0, 0.0), (math.nan, 1.0)):
        with pytest.raises(AiconError, match="Joint 'elbow': .*expected lower below upper"):
            Chain([IDENTITY], IDENTITY, [Joint("elbow", low=low, high=high)])


@pytest.mark.parametrize("shape", [(), (1,), (3,), (2, 1)])
def test_a_posture_has_a_number_for_each_joint(shape: tuple[int, ...]) -> None:
    for chain in (Chain([IDENTITY] * 2, IDENTITY), Chain([IDENTITY], IDENTITY)):
        if shape[-1:] == (len(chain.names),):
            assert chain(torch.zeros(shape)).shape == (*shape[:-1], 4, 4)
            continue
        with pytest.raises(AiconError, match="one for each joint of the chain"):
            chain(torch.zeros(shape))


@pytest.mark.parametrize("count", [0, -1, 1.5, "a"])
def test_a_link_has_a_capsule_or_more(count: Any) -> None:
    with pytest.raises(AiconError, match="per_link="):
        Capsules.from_urdf("<robot/>", per_link=count)


def test_a_height_is_a_number() -> None:
    with pytest.raises(AiconError, match="height=nan"):
        Table.under(Robot(panda_chain(), PANDA.shape), math.nan, SquaredHinge(0.05, 1.0))
    with pytest.raises(AiconError, match="height="):
        Grasp(GRIPPER, size=0.04, height=math.nan, reach=0.05)


def test_a_table_is_kept_off_by_links_that_rise() -> None:
    capsule = Capsule(1, (0.0, 0.0, 0.0), (0.4, 0.0, 0.0), 0.04)
    robot = Robot(Chain([IDENTITY], IDENTITY), Capsules((capsule,), ("arm",), ()))
    with pytest.raises(AiconError, match="none of its links moves up or down"):
        Table.under(robot, -1.0, SquaredHinge(0.05, 1.0))


def test_a_target_has_as_many_numbers_as_its_orientation() -> None:
    place = torch.zeros(3)
    for pose, orientation in (
        (TipPose("full"), None),
        (TipPose("full"), torch.ones(3)),
        (TipPose("axis"), torch.ones(4)),
    ):
        with pytest.raises(AiconError, match="orientation: got"):
            pose.target(place, orientation)


def test_a_step_has_no_more_parts_than_sub_steps() -> None:
    with pytest.raises(AiconError, match="parts=5: expected 1 to 2"):
        Servo.of(substeps=2).displacements(torch.ones(2), torch.zeros(2), 0.1, 5)
