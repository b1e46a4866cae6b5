"""The Panda in the scene: its servos, and the tool at its flange.

The tool is a push stick with a camera beside it and a force-torque sensor at its root.
"""

import mujoco
import numpy as np
from numpy.typing import NDArray

from aicon_envs.panda_push import collision_groups as groups

JOINTS = tuple(f"panda_joint{index}" for index in range(1, 8))
SPEED_LIMIT = (2.175, 2.175, 2.175, 2.175, 2.61, 2.61, 2.61)
"""Largest speed of each joint, rad/s."""

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

_GAINS = ((4500.0, 450.0),) * 4 + ((2000.0, 200.0),) * 3
"""Gains (kp, kv) of the velocity servos of the four large and the three small joints."""

_INVISIBLE = [0, 0, 0, 0]


def equip_robot(spec: mujoco.MjSpec) -> None:
    """Make the arm of a description a robot: bodies, servos, tool, camera and sensors."""
    _prepare_arm(spec)
    for joint, limit, gains in zip(JOINTS, SPEED_LIMIT, _GAINS, strict=True):
        _add_servo(spec, joint, limit, gains)

    tool = _add_tool(spec)
    _add_camera(tool)
    _add_wrist_sensor(spec)
    _exclude_contacts(spec)


def _prepare_arm(spec: mujoco.MjSpec) -> None:
    """Compensate the arm's gravity, as its controller does, and say what it collides with."""
    for body in spec.bodies:
        body.gravcomp = 1.0

    for geom in spec.geoms:
        geom.contype = groups.ROBOT
        geom.conaffinity = groups.ROBOT | groups.OBJECT | groups.TABLE
        geom.rgba = [0.85, 0.85, 0.87, 1.0]
        geom.group = 1


def _add_servo(
    spec: mujoco.MjSpec, joint: str, speed_limit: float, gains: tuple[float, float]
) -> None:
    """Add a velocity servo: the integral of its command is the target of a position servo."""
    stiffness, damping = gains
    low, high = spec.joint(joint).range
    actuator = spec.add_actuator(name=joint, trntype=mujoco.mjtTrn.mjTRN_JOINT, target=joint)

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


def _add_tool(spec: mujoco.MjSpec) -> mujoco.MjsBody:
    """Add the stick and the body of the camera to the flange; its weight is not compensated."""
    tool = spec.body("panda_link8").add_body(name="tool")
    tool.gravcomp = 0.0
    tool.explicitinertial = True
    tool.mass = TOOL_MASS
    tool.ipos = [0.015, 0.0, 0.09]
    tool.inertia = [2e-3, 2e-3, 2e-4]

    # Where the sensor measures, and where the policy's end effector is.
    tool.add_site(name="wrench", size=[0.005, 0.0, 0.0], rgba=_INVISIBLE)
    tool.add_site(name="tip", pos=[0, 0, STICK_LENGTH], size=[0.004, 0.0, 0.0], rgba=_INVISIBLE)

    tool.add_geom(
        name="stick",
        type=mujoco.mjtGeom.mjGEOM_CYLINDER,
        fromto=[0, 0, 0, 0, 0, STICK_LENGTH],
        size=[STICK_RADIUS, 0, 0],
        rgba=[0.15, 0.15, 0.15, 1.0],
        contype=groups.ROBOT,
        conaffinity=groups.ROBOT | groups.OBJECT | groups.TABLE,
        friction=[0.2, 0.005, 0.0001],
        priority=1,
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


def _add_camera(tool: mujoco.MjsBody) -> None:
    tool.add_camera(name="hand", pos=list(CAMERA), quat=_camera_rotation(), fovy=FIELD_OF_VIEW)


def _camera_rotation() -> NDArray[np.float64]:
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


def _exclude_contacts(spec: mujoco.MjSpec) -> None:
    """Exclude contacts that are none."""
    # The stick begins inside the flange.
    spec.add_exclude(bodyname1="tool", bodyname2="panda_link6")
    spec.add_exclude(bodyname1="tool", bodyname2="panda_link7")

    # The meshes of these links touch.
    spec.add_exclude(bodyname1="panda_link5", bodyname2="panda_link7")
