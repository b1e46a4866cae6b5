"""The scene: a robot with velocity servos, and balls that it should not touch.

The root of the robot is the origin, z points up. There is no table: what counts is the robot.
"""

from functools import lru_cache
from typing import NamedTuple

import mujoco
import numpy as np

from aicon_envs.arrays import BoolArray, FloatArray
from aicon_envs.reach.contacts import SAMPLES, excluded_pairs
from aicon_envs.reach.robots import Robot, draw_postures
from aicon_envs.reach.urdf import Description, read_description

TIMESTEP = 0.002
"""Of the physics, s."""

BANDWIDTH = 60.0
"""Of the servos, rad/s: a joint alone follows a step of its velocity in a tenth of a second."""

ROTOR = 0.1
"""Inertia of a rotor as its joint feels it through the gears, kg m²."""


class Scene(NamedTuple):
    """A compiled scene.

    Attributes:
        model: The scene.
        joints: Names of the robot's n joints.
        low: Lower limits of the joints, ``(n,)``, rad or m; −∞ where there is none.
        high: Upper limits.
        speed: Largest speeds of the description, rad/s or m/s.
        turns: Which joints turn, ``(n,)``; the others slide.
    """

    model: mujoco.MjModel
    joints: tuple[str, ...]
    low: FloatArray
    high: FloatArray
    speed: FloatArray
    turns: BoolArray


@lru_cache(maxsize=8)  # environments side by side share what none of them changes
def build_scene(robot: Robot, balls: int = 0, ball_radius: float = 0.08) -> Scene:
    """Compile the scene.

    Args:
        robot: The robot.
        balls: Number of balls.
        ball_radius: Their radius, m.

    Raises:
        ValueError: If the robot has no such tip.
    """
    arm = prepare_arm(robot)
    spec = arm.spec
    _add_tip(spec, robot.tip)
    _add_balls(spec, balls, ball_radius)
    _add_surroundings(spec, arm.span)
    return Scene(spec.compile(), arm.joints, arm.low, arm.high, arm.speed, arm.turns)


class PreparedArm(NamedTuple):
    """A robot with its servos, before it is compiled.

    Attributes:
        spec: The robot alone.
        span: What it does in random postures.
        joints, low, high, speed, turns: As :class:`Scene` has them.
    """

    spec: mujoco.MjSpec
    span: "_Span"
    joints: tuple[str, ...]
    low: FloatArray
    high: FloatArray
    speed: FloatArray
    turns: BoolArray


def prepare_arm(robot: Robot) -> PreparedArm:
    """Read a robot, and give it servos; links that cannot but touch do not collide.

    Args:
        robot: The robot.
    """
    description = read_description(robot)
    bare = _compile_bare(description)
    low, high, turns = _limits(bare, description.joints)
    span = _survey(bare, description.joints, low, high)

    spec = _read(description)
    set_physics(spec)
    _add_servos(spec, description.joints, span.inertias)
    for first, second in excluded_pairs(bare, robot, description.joints, low, high):
        spec.add_exclude(bodyname1=first, bodyname2=second)
    compensate_and_paint(spec)
    speeds = np.array(description.speeds)
    return PreparedArm(spec, span, description.joints, low, high, speeds, turns)


def _read(description: Description) -> mujoco.MjSpec:
    """Return the robot alone, with the rotors that its description says nothing of."""
    spec = mujoco.MjSpec.from_string(description.text, assets=dict(description.assets))
    for name in description.joints:
        joint = spec.joint(name)
        if joint.type == mujoco.mjtJoint.mjJNT_HINGE:
            joint.armature = ROTOR
    return spec


def _compile_bare(description: Description) -> mujoco.MjModel:
    """Compile the robot alone, with all contacts but those of what is fixed to each other."""
    spec = _read(description)
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_FILTERPARENT.value
    return spec.compile()


def _limits(
    model: mujoco.MjModel, joints: tuple[str, ...]
) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Return lower and upper limits of the joints, and which turn."""
    numbers = [model.joint(name).id for name in joints]
    limited = model.jnt_limited[numbers].astype(bool)

    low = np.where(limited, model.jnt_range[numbers, 0], -np.inf)
    high = np.where(limited, model.jnt_range[numbers, 1], np.inf)
    turns = model.jnt_type[numbers] == mujoco.mjtJoint.mjJNT_HINGE.value
    return low, high, turns


class _Span(NamedTuple):
    """What a robot does in random postures.

    Attributes:
        inertias: The largest inertia that each joint moves, ``(n,)``, kg m² or kg.
        low: The least coordinates that a body comes to, ``(3,)``, m.
        high: The largest.
    """

    inertias: FloatArray
    low: FloatArray
    high: FloatArray


def _survey(
    model: mujoco.MjModel, joints: tuple[str, ...], low: FloatArray, high: FloatArray
) -> _Span:
    """Move a robot to random postures."""
    data = mujoco.MjData(model)
    addresses = [model.joint(name).qposadr[0] for name in joints]
    degrees = [model.joint(name).dofadr[0] for name in joints]
    span = _Span(np.zeros(len(joints)), np.full(3, np.inf), np.full(3, -np.inf))

    for posture in draw_postures(low, high, SAMPLES, np.random.default_rng(1)):
        data.qpos[addresses] = posture
        mujoco.mj_forward(model, data)
        span = _Span(
            np.maximum(span.inertias, _inertias(model, data)[degrees]),
            np.minimum(span.low, data.xpos.min(axis=0)),
            np.maximum(span.high, data.xpos.max(axis=0)),
        )
    return span


def _inertias(model: mujoco.MjModel, data: mujoco.MjData) -> FloatArray:
    """The diagonal of the mass matrix, ``(nv,)``, by products: `mj_fullM` differs by version."""
    columns = np.zeros((model.nv, model.nv))
    for column, unit in zip(columns, np.eye(model.nv), strict=True):
        mujoco.mj_mulM(model, data, column, unit)
    return np.diag(columns)


def set_physics(spec: mujoco.MjSpec) -> None:
    """Set how the physics are computed."""
    spec.modelname = "reach"
    spec.option.timestep = TIMESTEP
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST


def compensate_and_paint(spec: mujoco.MjSpec) -> None:
    """Compensate the arm's gravity, as its controller does, and paint it."""
    for body in spec.bodies:
        body.gravcomp = 1.0

    for geom in spec.geoms:
        geom.rgba = [0.85, 0.85, 0.87, 1.0]
        geom.group = 1


def _add_servos(spec: mujoco.MjSpec, joints: tuple[str, ...], inertias: FloatArray) -> None:
    """Add a velocity servo to each joint: torque = d u + kᵥ (u − q̇) + kₚ ∫ (u − q̇).

    u is the command and d the joint's own damping, which the first term makes up for. With inertia
    M and bandwidth ω, kᵥ = 2 M ω and kₚ = M ω². The integral is where the commands led, minus
    where the joint is.
    """
    for joint, inertia in zip(joints, inertias.tolist(), strict=True):
        speed_gain = 2.0 * inertia * BANDWIDTH
        actuator = spec.add_actuator(name=f"{joint}_velocity", target=joint)
        actuator.trntype = mujoco.mjtTrn.mjTRN_JOINT
        actuator.gainprm[0] = speed_gain + float(np.ravel(spec.joint(joint).damping)[0])
        actuator.biastype = mujoco.mjtBias.mjBIAS_AFFINE
        actuator.biasprm[2] = -speed_gain

    for joint, inertia in zip(joints, inertias.tolist(), strict=True):
        stiffness = inertia * BANDWIDTH**2
        actuator = spec.add_actuator(name=f"{joint}_integral", target=joint)
        actuator.trntype = mujoco.mjtTrn.mjTRN_JOINT
        actuator.dyntype = mujoco.mjtDyn.mjDYN_INTEGRATOR
        actuator.gainprm[0] = stiffness
        actuator.biastype = mujoco.mjtBias.mjBIAS_AFFINE
        actuator.biasprm[1] = -stiffness


def _add_tip(spec: mujoco.MjSpec, tip: str) -> None:
    """Mark the tip, and show where it should go."""
    spec.body(tip).add_site(name="tip", size=[0.01, 0.0, 0.0], rgba=[0.1, 0.2, 0.8, 1.0])

    target = spec.worldbody.add_body(name="target", mocap=True)
    target.add_site(name="target", size=[0.015, 0.0, 0.0], rgba=[0.1, 0.6, 0.25, 0.8])
    for axis, color in enumerate(np.eye(3)):
        end = np.zeros(3)
        end[axis] = 0.1
        target.add_site(
            name=f"target_axis{axis}",
            type=mujoco.mjtGeom.mjGEOM_CYLINDER,
            fromto=[0.0, 0.0, 0.0, *end],
            size=[0.004, 0.0, 0.0],
            rgba=[*color, 0.8],
        )


def _add_balls(spec: mujoco.MjSpec, count: int, radius: float) -> None:
    """Add balls, which are where they are put."""
    for number in range(1, count + 1):
        body = spec.worldbody.add_body(name=f"ball_{number}", mocap=True)
        body.add_geom(
            name=f"ball_{number}",
            type=mujoco.mjtGeom.mjGEOM_SPHERE,
            size=[radius, 0.0, 0.0],
            rgba=[0.85, 0.25, 0.15, 1.0],
        )


def _add_surroundings(spec: mujoco.MjSpec, span: _Span) -> None:
    """Add what is seen only: the sky, and a camera that looks at the whole robot from outside."""
    add_sky(spec)

    # So far away that the whole robot is seen.
    center, size = (span.low + span.high) / 2.0, np.linalg.norm(span.high - span.low)
    away, right = np.array([0.55, -0.7, 0.25]), np.array([0.7, 0.55, 0.0])
    up = np.cross(right, -away)
    spec.worldbody.add_camera(
        name="outside",
        pos=center + size * away,
        xyaxes=[*right, *up],
        fovy=42.0,
    )


def add_sky(spec: mujoco.MjSpec) -> None:
    """Add a bright sky, and light from all sides."""
    visual = spec.visual
    visual.quality.shadowsize = 0
    visual.global_.offwidth, visual.global_.offheight = 1280, 960
    visual.headlight.ambient = [0.4, 0.4, 0.4]
    visual.headlight.diffuse = [0.5, 0.5, 0.5]
    visual.headlight.specular = [0.0, 0.0, 0.0]

    spec.add_texture(
        name="sky",
        type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
        rgb1=[0.93, 0.94, 0.96],
        rgb2=[0.75, 0.78, 0.82],
        width=64,
        height=64 * 6,
    )
