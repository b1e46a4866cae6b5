"""The scene: an arm with a push stick and a camera in hand, a table and an object.

Frames: the base of the robot is the origin, x points to the table, z up, and the top of the table
is at z = 0.
"""

import mujoco
import numpy as np

from aicon_envs.arm_push import collision_groups as groups
from aicon_envs.arm_push.objects import THICKNESS, Prism
from aicon_envs.arm_push.robot import equip_robot
from aicon_envs.arm_push.urdf import load_arm
from aicon_envs.arrays import FloatArray
from aicon_envs.reach.robots import Robot

TABLE = ((0.25, 0.95), (-0.55, 0.55))
"""Extent of the table in x and y, m."""

TIMESTEP = 0.001
"""Of the physics, s."""

TARGET_GROUP = 4
"""Group of the shape that shows the target in pictures from outside; no sensor sees it."""

TARGET_HEIGHT = -THICKNESS / 2 + 0.001
"""Height of that shape's middle, m: it lies on the table like a sheet."""


def build_scene(
    arm: Robot,
    object: Prism,
    mass: float = 0.5,
    friction: float = 0.35,
) -> mujoco.MjModel:
    """Compile the scene.

    Args:
        arm: What pushes; its joints are the first ones of the model.
        object: What is pushed.
        mass: Its mass, kg.
        friction: Coefficient of sliding friction between object and table.

    Raises:
        ValueError: If the arm cannot push; it says what it lacks.
    """
    description = load_arm(arm)
    spec = mujoco.MjSpec.from_string(description.text, assets=dict(description.assets))
    spec.modelname = "arm_push"

    _set_physics(spec)
    _set_light(spec)

    equip_robot(spec, arm, description)
    _add_world(spec)
    _add_meshes(spec, object)
    _add_object(spec, object, mass, friction)
    _add_target(spec, object)

    return spec.compile()


def _set_physics(spec: mujoco.MjSpec) -> None:
    spec.option.timestep = TIMESTEP
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC  # a pyramid lets the object slip sideways
    spec.option.impratio = 10.0


def _set_light(spec: mujoco.MjSpec) -> None:
    visual = spec.visual
    visual.quality.shadowsize = 0
    visual.global_.offwidth, visual.global_.offheight = 640, 480
    visual.map.znear, visual.map.zfar = 0.01, 10.0

    visual.headlight.ambient = [0.35, 0.35, 0.35]
    visual.headlight.diffuse = [0.45, 0.45, 0.45]
    visual.headlight.specular = [0.0, 0.0, 0.0]


def _add_world(spec: mujoco.MjSpec) -> None:
    """Add the table, the floor, a light and the camera that looks from outside."""
    (left, right), (near, far) = TABLE
    world = spec.worldbody

    world.add_geom(
        name="table",
        type=mujoco.mjtGeom.mjGEOM_BOX,
        pos=[(left + right) / 2, (near + far) / 2, -0.02],
        size=[(right - left) / 2, (far - near) / 2, 0.02],
        rgba=[0.80, 0.78, 0.74, 1.0],
        contype=groups.TABLE,
        conaffinity=groups.ROBOT | groups.OBJECT,
    )

    world.add_geom(
        name="floor",
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        pos=[0, 0, -0.4],
        size=[3, 3, 0.1],
        rgba=[0.35, 0.37, 0.40, 1.0],
        contype=groups.TABLE,
        conaffinity=groups.ROBOT | groups.OBJECT,
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


def _add_meshes(spec: mujoco.MjSpec, object: Prism) -> None:
    """Add a mesh for each convex part of the object: its polygon below and above."""
    for index, part in enumerate(object.parts):
        bottom = np.column_stack((part, np.full(len(part), -THICKNESS / 2)))
        top = np.column_stack((part, np.full(len(part), THICKNESS / 2)))

        mesh = spec.add_mesh(name=_mesh_name(index))
        mesh.uservert = np.concatenate([bottom, top]).ravel().tolist()


def _add_object(spec: mujoco.MjSpec, object: Prism, mass: float, friction: float) -> None:
    """Add the object, which moves freely, and its marker."""
    body = spec.worldbody.add_body(name="object", pos=[0.54, 0.0, THICKNESS / 2])
    body.add_freejoint(name="object")

    # The mass is spread over the parts by their areas. With a higher priority than the table's,
    # the friction between them is the object's.
    total_area = sum(_area(part) for part in object.parts)
    for index, part in enumerate(object.parts):
        body.add_geom(
            name=_mesh_name(index),
            type=mujoco.mjtGeom.mjGEOM_MESH,
            meshname=_mesh_name(index),
            mass=mass * _area(part) / total_area,
            rgba=[0.80, 0.12, 0.12, 1.0],
            contype=groups.OBJECT,
            conaffinity=groups.ROBOT | groups.TABLE,
            friction=[friction, 0.005, 0.0001],
            priority=1,
            condim=4,
        )

    # The reference marker, a dot on top, in the middle of the first part.
    x, y = object.parts[0].mean(axis=0).tolist()
    body.add_geom(
        name="marker",
        type=mujoco.mjtGeom.mjGEOM_CYLINDER,
        pos=[x, y, THICKNESS / 2],
        size=[0.008, 0.0004, 0],
        mass=0.0,
        rgba=[0.10, 0.20, 0.80, 1.0],
        contype=groups.FREE,
        conaffinity=groups.FREE,
    )
    body.add_site(name="object", size=[0.002, 0, 0], rgba=[0, 0, 0, 0])


def _add_target(spec: mujoco.MjSpec, object: Prism) -> None:
    """Add the sheet that shows the target; it collides with nothing."""
    target = spec.worldbody.add_body(name="target", pos=[0.54, 0.0, TARGET_HEIGHT], mocap=True)

    for index in range(len(object.parts)):
        target.add_geom(
            type=mujoco.mjtGeom.mjGEOM_MESH,
            meshname=_mesh_name(index),
            rgba=[0.10, 0.60, 0.25, 0.35],
            contype=groups.FREE,
            conaffinity=groups.FREE,
            group=TARGET_GROUP,
        )


def _mesh_name(index: int) -> str:
    return f"part{index}"


def _area(polygon: FloatArray) -> float:
    """Return the area of a polygon ``(n, 2)``, m²."""
    x, y = polygon.T
    return float(abs(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2)
