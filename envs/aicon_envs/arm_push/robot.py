"""The arm in the scene: its servos, and the tool at its flange.

The tool is a push stick with a camera beside it and a force-torque sensor at its root.
"""

import math
from functools import lru_cache

import mujoco
import numpy as np

from aicon_envs.arm_push import collision_groups as groups
from aicon_envs.arm_push.urdf import load_arm
from aicon_envs.arrays import FloatArray
from aicon_envs.reach.contacts import excluded_pairs
from aicon_envs.reach.robots import Robot
from aicon_envs.reach.scene import compensate_and_paint
from aicon_envs.reach.urdf import Description

FEWEST_JOINTS = 6
"""The stick is upright, its tip at a place, and the camera's side at an angle."""

STICK_LENGTH = 0.30
"""From the flange to the tip, m."""

STICK_RADIUS = 0.015
"""Radius of the push stick, m."""

TOOL_MASS = 0.25
"""Mass of stick, camera and mount, kg."""

CAMERA = (0.06, 0.0, 0.03)
"""Position of the camera in the frame of the tool, m; z points from the flange to the tip."""

CAMERA_TILT = 0.10
"""Rotation of the camera toward the tip, rad."""

FIELD_OF_VIEW = 70.0
"""Vertical field of view, degrees."""

_TWIST = 0.02
"""Twist at which a servo without gains of its own gives the largest torque of its joint, rad."""

_LAG = 0.1
"""By which such a servo lags behind its command, s."""

_INVISIBLE = [0, 0, 0, 0]


def equip_robot(spec: mujoco.MjSpec, arm: Robot, description: Description) -> None:
    """Make the arm of a description a robot: bodies, servos, tool, camera and sensors.

    Raises:
        ValueError: If the arm cannot push; it names the joint and what is missing.
    """
    count = len(description.joints)
    if count < FEWEST_JOINTS:
        raise ValueError(
            f"robot: its tip {arm.tip!r} must be moved by {FEWEST_JOINTS} joints or more, "
            f"for a stick that stays upright; it is by {count}"
        )
    if arm.gains is not None and np.shape(arm.gains) != (count, 2):
        raise ValueError(f"gains must be one pair for each of {count} joints, got {arm.gains}")

    # The arm's own joints, ...
    _prepare_arm(spec)
    for index, (name, speed) in enumerate(zip(description.joints, description.speeds, strict=True)):
        joint = spec.joint(name)
        _check_joint(joint, speed)
        gains = _default_gains(joint) if arm.gains is None else arm.gains[index]
        _add_servo(spec, joint, speed, gains)

    # ... and what is at its flange.
    tool = _add_tool(spec, arm.tip)
    tool.add_camera(name="hand", pos=list(CAMERA), quat=_camera_rotation(), fovy=FIELD_OF_VIEW)
    _add_wrist_sensor(spec)
    for first, second in _excluded_contacts(arm):
        spec.add_exclude(bodyname1=first, bodyname2=second)


def _check_joint(joint: mujoco.MjsJoint, speed: float) -> None:
    """Check that a joint turns within limits of angle, speed and torque.

    Raises:
        ValueError: If it does not; it names the joint and what its description lacks.
    """
    low, high = joint.range
    needs = {
        "turn": joint.type == mujoco.mjtJoint.mjJNT_HINGE,
        "have limits": low < high,
        "have a largest speed": math.isfinite(speed),
        "have a largest torque": joint.actfrcrange[1] > 0.0,
    }
    for what, is_there in needs.items():
        if not is_there:
            raise ValueError(f"robot: its joint {joint.name} must {what}, for the stick to push")


def _prepare_arm(spec: mujoco.MjSpec) -> None:
    """Compensate the arm's gravity, paint it, and say what it collides with."""
    compensate_and_paint(spec)
    for geom in spec.geoms:
        geom.contype = groups.ROBOT
        geom.conaffinity = groups.ROBOT | groups.OBJECT | groups.TABLE


def _default_gains(joint: mujoco.MjsJoint) -> tuple[float, float]:
    """Return stiffness (Nm/rad) and damping (Nms/rad) that go with the torque of a joint."""
    stiffness = float(joint.actfrcrange[1]) / _TWIST
    return stiffness, _LAG * stiffness


def _add_servo(
    spec: mujoco.MjSpec, joint: mujoco.MjsJoint, speed_limit: float, gains: tuple[float, float]
) -> None:
    """Add a velocity servo: the integral of its command is the target of a position servo."""
    stiffness, damping = gains
    low, high = joint.range
    actuator = spec.add_actuator(
        name=joint.name, trntype=mujoco.mjtTrn.mjTRN_JOINT, target=joint.name
    )

    # The integral of the command, within the joint's limits.
    actuator.dyntype = mujoco.mjtDyn.mjDYN_INTEGRATOR
    actuator.actlimited = 1
    actuator.actrange = [low, high]

    # Torque = stiffness (integral - angle) - damping · velocity.
    actuator.gaintype = mujoco.mjtGain.mjGAIN_FIXED
    actuator.gainprm[0] = stiffness
    actuator.biastype = mujoco.mjtBias.mjBIAS_AFFINE
    actuator.biasprm[1] = -stiffness
    actuator.biasprm[2] = -damping

    actuator.ctrllimited = 1
    actuator.ctrlrange = [-speed_limit, speed_limit]


def _add_tool(spec: mujoco.MjSpec, flange: str) -> mujoco.MjsBody:
    """Add the stick and the body of the camera to the flange; its weight is not compensated."""
    tool = spec.body(flange).add_body(name="tool")
    tool.gravcomp = 0.0
    tool.explicitinertial = True
    tool.mass = TOOL_MASS
    tool.ipos = [0.015, 0.0, 0.09]
    tool.inertia = [2e-3, 2e-3, 2e-4]

    # Where the sensor measures, and where the policy's end effector is.
    tool.add_site(name="wrench", size=[0.005, 0.0, 0.0], rgba=_INVISIBLE)
    tool.add_site(name="tip", pos=[0, 0, STICK_LENGTH], size=[0.004, 0.0, 0.0], rgba=_INVISIBLE)

    # With a higher priority than all others the friction at the stick is its own; of two equals
    # MuJoCo would take the larger.
    tool.add_geom(
        name="stick",
        type=mujoco.mjtGeom.mjGEOM_CYLINDER,
        fromto=[0, 0, 0, 0, 0, STICK_LENGTH],
        size=[STICK_RADIUS, 0, 0],
        rgba=[0.15, 0.15, 0.15, 1.0],
        contype=groups.ROBOT,
        conaffinity=groups.ROBOT | groups.OBJECT | groups.TABLE,
        friction=[0.2, 0.005, 0.0001],
        priority=2,
        condim=4,
    )

    # Seen only; for distances it has a capsule.
    tool.add_geom(
        name="camera_body",
        type=mujoco.mjtGeom.mjGEOM_BOX,
        pos=[CAMERA[0], CAMERA[1], CAMERA[2] - 0.02],
        size=[0.012, 0.02, 0.01],
        rgba=[0.1, 0.1, 0.1, 1.0],
        contype=groups.FREE,
        conaffinity=groups.FREE,
    )
    return tool


def _camera_rotation() -> FloatArray:
    """Return the quaternion of a camera that looks along the tool, tilted toward the tip.

    MuJoCo's cameras look along -z with y up: half a turn looks along z.
    """
    half_turn = np.array([0.0, np.sqrt(0.5), np.sqrt(0.5), 0.0])
    tilt = np.array([np.cos(CAMERA_TILT / 2), 0.0, -np.sin(CAMERA_TILT / 2), 0.0])

    rotation = np.zeros(4)
    mujoco.mju_mulQuat(rotation, tilt, half_turn)
    return rotation


def _add_wrist_sensor(spec: mujoco.MjSpec) -> None:
    """Measure force and torque between flange and tool."""
    sensors = {
        "force": mujoco.mjtSensor.mjSENS_FORCE,
        "torque": mujoco.mjtSensor.mjSENS_TORQUE,
    }
    for name, kind in sensors.items():
        spec.add_sensor(name=name, type=kind, objtype=mujoco.mjtObj.mjOBJ_SITE, objname="wrench")


@lru_cache(maxsize=8)  # what is pushed changes nothing of it
def _excluded_contacts(arm: Robot) -> list[tuple[str, str]]:
    """Return the pairs of links whose contacts mean nothing, those with the tool among them."""
    description = load_arm(arm)
    spec = mujoco.MjSpec.from_string(description.text, assets=dict(description.assets))
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_FILTERPARENT.value
    _add_tool(spec, arm.tip)
    model = spec.compile()

    low, high = model.jnt_range.T
    return excluded_pairs(model, arm, description.joints, low, high)
