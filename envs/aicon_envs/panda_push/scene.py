"""The scene: the Panda of `example-robot-data` with a push stick, a camera in hand, a table and an object.

Frames: the base of the robot is the origin, x points to the table, z up, and the top of the table is at z = 0.
"""

import importlib.metadata
from pathlib import Path
from xml.etree import ElementTree

import mujoco
import numpy as np

from aicon_envs.panda_push.objects import THICKNESS, Prism

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

TABLE = ((0.25, 0.95), (-0.55, 0.55))
"""Extent of the table in x and y, m."""

TARGET_GROUP = 4
"""Group of the shape that shows the target in pictures from outside; no sensor sees it."""

TARGET_HEIGHT = -THICKNESS / 2 + 0.001
"""Height of that shape's middle, m: it lies on the table like a sheet."""

# Gains (kp, kv) of the velocity servos of the four large and the three small joints.
_GAINS = ((4500.0, 450.0),) * 4 + ((2000.0, 200.0),) * 3
_FREE, _ROBOT, _OBJECT, _TABLE = 0, 1, 2, 4  # collision groups


def build(
    object: Prism, mass: float = 0.5, friction: float = 0.35, timestep: float = 0.001
) -> mujoco.MjModel:
    """Compile the scene.

    Args:
        object: What is pushed.
        mass: Its mass, kg.
        friction: Coefficient of sliding friction between object and table.
        timestep: Time step of the physics, s.
    """
    spec = mujoco.MjSpec.from_string(_description())
    spec.modelname = "panda_push"
    spec.option.timestep = timestep
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.cone = (
        mujoco.mjtCone.mjCONE_ELLIPTIC
    )  # a pyramidal cone lets the object slip sideways
    spec.option.impratio = 10.0
    spec.visual.quality.shadowsize = 0
    spec.visual.global_.offwidth, spec.visual.global_.offheight = 640, 480
    spec.visual.headlight.ambient = [0.35, 0.35, 0.35]
    spec.visual.headlight.diffuse = [0.45, 0.45, 0.45]
    spec.visual.headlight.specular = [0.0, 0.0, 0.0]
    spec.visual.map.znear, spec.visual.map.zfar = 0.01, 10.0
    _add_robot(spec)
    _add_world(spec)
    _add_object(spec, object, mass, friction)
    return spec.compile()


def _description() -> str:
    """The description of the arm without hand and pictures, with its meshes found."""
    folder = _description_folder()
    root = ElementTree.fromstring((folder / "urdf" / "panda.urdf").read_text())
    for link in root.findall("link"):
        for visual in link.findall("visual"):
            link.remove(visual)
        for mesh in link.iter("mesh"):
            mesh.set("filename", str(mesh.get("filename")).rsplit("/", 1)[-1])
    for tag in ("link", "joint"):
        for element in root.findall(tag):
            if any(part in str(element.get("name")) for part in ("hand", "finger")):
                root.remove(element)
    options = ElementTree.SubElement(root, "mujoco")
    ElementTree.SubElement(
        options,
        "compiler",
        meshdir=str(folder / "meshes" / "collision"),
        fusestatic="false",  # the flange stays a body
        discardvisual="false",  # true would drop what does not collide
    )
    return ElementTree.tostring(root, encoding="unicode")


def _description_folder() -> Path:
    try:
        files = importlib.metadata.files("example-robot-data") or []
    except importlib.metadata.PackageNotFoundError as error:
        raise ModuleNotFoundError(
            "the description of the Panda is missing; it comes with: pip install 'aicon-torch[panda]'"
        ) from error
    for file in files:
        if file.name == "panda.urdf":
            return Path(str(file.locate())).resolve().parents[1]
    raise ModuleNotFoundError("example-robot-data has no panda.urdf; expected version 6")


def _add_robot(spec: mujoco.MjSpec) -> None:
    for body in spec.bodies:
        body.gravcomp = 1.0
    for geom in spec.geoms:
        geom.contype, geom.conaffinity = _ROBOT, _ROBOT | _OBJECT | _TABLE
        geom.rgba = [0.85, 0.85, 0.87, 1.0]
        geom.group = 1
    for joint, limit, (stiffness, damping) in zip(JOINTS, SPEED_LIMIT, _GAINS, strict=True):
        low, high = spec.joint(joint).range
        actuator = spec.add_actuator(name=joint, trntype=mujoco.mjtTrn.mjTRN_JOINT, target=joint)
        actuator.dyntype = (
            mujoco.mjtDyn.mjDYN_INTEGRATOR
        )  # the command is a velocity, its integral a position servo's
        actuator.gaintype, actuator.gainprm[0] = mujoco.mjtGain.mjGAIN_FIXED, stiffness
        actuator.biastype, actuator.biasprm[1], actuator.biasprm[2] = (
            mujoco.mjtBias.mjBIAS_AFFINE,
            -stiffness,
            -damping,
        )
        actuator.actlimited, actuator.actrange = 1, [low, high]
        actuator.ctrllimited, actuator.ctrlrange = 1, [-limit, limit]
    flange = spec.body("panda_link8")
    tool = flange.add_body(name="tool")
    tool.gravcomp = 0.0
    tool.explicitinertial = True
    tool.mass, tool.ipos, tool.inertia = TOOL_MASS, [0.015, 0.0, 0.09], [2e-3, 2e-3, 2e-4]
    tool.add_site(name="wrench", size=[0.005, 0.0, 0.0], rgba=[0, 0, 0, 0])
    tool.add_site(name="tip", pos=[0, 0, STICK_LENGTH], size=[0.004, 0.0, 0.0], rgba=[0, 0, 0, 0])
    tool.add_geom(
        name="stick",
        type=mujoco.mjtGeom.mjGEOM_CYLINDER,
        fromto=[0, 0, 0, 0, 0, STICK_LENGTH],
        size=[STICK_RADIUS, 0, 0],
        rgba=[0.15, 0.15, 0.15, 1.0],
        contype=_ROBOT,
        conaffinity=_ROBOT | _OBJECT | _TABLE,
        friction=[0.2, 0.005, 0.0001],
        priority=1,
        condim=4,
    )
    tool.add_geom(
        name="camera_body",
        type=mujoco.mjtGeom.mjGEOM_BOX,
        pos=[CAMERA[0], CAMERA[1], CAMERA[2] - 0.02],
        size=[0.012, 0.02, 0.01],
        rgba=[0.1, 0.1, 0.1, 1.0],
        contype=_FREE,
        conaffinity=_FREE,
    )
    # MuJoCo's cameras look along -z with y up: half a turn about x looks along the tool.
    half = np.array([np.cos(CAMERA_TILT / 2), 0.0, np.sin(CAMERA_TILT / 2), 0.0])
    turned = np.zeros(4)
    mujoco.mju_mulQuat(
        turned, half * [1, 1, -1, 1], np.array([0.0, np.sqrt(0.5), np.sqrt(0.5), 0.0])
    )
    tool.add_camera(name="hand", pos=list(CAMERA), quat=turned, fovy=FIELD_OF_VIEW)
    for link in ("panda_link6", "panda_link7"):
        spec.add_exclude(bodyname1="tool", bodyname2=link)  # the stick begins inside the flange
    spec.add_exclude(bodyname1="panda_link5", bodyname2="panda_link7")  # whose meshes touch
    for name, kind in (
        ("force", mujoco.mjtSensor.mjSENS_FORCE),
        ("torque", mujoco.mjtSensor.mjSENS_TORQUE),
    ):
        spec.add_sensor(name=name, type=kind, objtype=mujoco.mjtObj.mjOBJ_SITE, objname="wrench")


def _add_world(spec: mujoco.MjSpec) -> None:
    (left, right), (near, far) = TABLE
    world = spec.worldbody
    world.add_geom(
        name="table",
        type=mujoco.mjtGeom.mjGEOM_BOX,
        pos=[(left + right) / 2, (near + far) / 2, -0.02],
        size=[(right - left) / 2, (far - near) / 2, 0.02],
        rgba=[0.80, 0.78, 0.74, 1.0],
        contype=_TABLE,
        conaffinity=_ROBOT | _OBJECT,
    )
    world.add_geom(
        name="floor",
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        pos=[0, 0, -0.4],
        size=[3, 3, 0.1],
        rgba=[0.35, 0.37, 0.40, 1.0],
        contype=_TABLE,
        conaffinity=_ROBOT | _OBJECT,
    )
    world.add_light(
        pos=[0.4, -0.6, 1.8],
        dir=[0.1, 0.3, -1.0],
        castshadow=False,
        diffuse=[0.35] * 3,
        specular=[0] * 3,
    )
    world.add_camera(
        name="outside",
        pos=[1.45, -0.85, 0.80],
        xyaxes=[0.62, 0.785, 0.0, -0.38, 0.30, 0.875],
        fovy=42.0,
    )


def _add_object(spec: mujoco.MjSpec, object: Prism, mass: float, friction: float) -> None:
    body = spec.worldbody.add_body(name="object", pos=[0.54, 0.0, THICKNESS / 2])
    body.add_freejoint(name="object")
    target = spec.worldbody.add_body(name="target", pos=[0.54, 0.0, TARGET_HEIGHT], mocap=True)
    area = sum(_area(part) for part in object.parts)
    for index, part in enumerate(object.parts):
        vertices = np.concatenate(
            [
                np.column_stack((part, np.full(len(part), z)))
                for z in (-THICKNESS / 2, THICKNESS / 2)
            ]
        )
        mesh = spec.add_mesh(name=f"part{index}")
        mesh.uservert = vertices.ravel().tolist()
        body.add_geom(
            name=f"part{index}",
            type=mujoco.mjtGeom.mjGEOM_MESH,
            meshname=f"part{index}",
            mass=mass * _area(part) / area,
            rgba=[0.80, 0.12, 0.12, 1.0],
            contype=_OBJECT,
            conaffinity=_ROBOT | _TABLE,
            friction=[friction, 0.005, 0.0001],
            priority=1,
            condim=4,
        )
        target.add_geom(
            type=mujoco.mjtGeom.mjGEOM_MESH,
            meshname=f"part{index}",
            rgba=[0.10, 0.60, 0.25, 0.35],
            contype=_FREE,
            conaffinity=_FREE,
            group=TARGET_GROUP,
        )
    x, y = marker_position(object)
    body.add_geom(
        name="marker",
        type=mujoco.mjtGeom.mjGEOM_CYLINDER,
        pos=[x, y, THICKNESS / 2],
        size=[0.008, 0.0004, 0],
        mass=0.0,
        rgba=[0.10, 0.20, 0.80, 1.0],
        contype=_FREE,
        conaffinity=_FREE,
    )
    body.add_site(name="object", size=[0.002, 0, 0], rgba=[0, 0, 0, 0])


def marker_position(object: Prism) -> tuple[float, float]:
    """Where the reference marker is on the object, m: the middle of its first part."""
    x, y = object.parts[0].mean(axis=0).tolist()
    return x, y


def _area(polygon: np.ndarray) -> float:
    x, y = polygon.T
    return float(abs(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2)
