"""A problem of `clutter.py` as MuJoCo has it: a robot as spheres, and the objects about it."""

import math
from typing import Any

import mujoco
import numpy as np
import torch
from scipy.spatial.transform import Rotation

from aicon_baselines.worlds.motion_bench_maker import Problem
from aicon_torch.parts import Robot
from clutter import Array


def model_of(robot: Robot, problem: Problem) -> mujoco.MjSpec:
    """Joints by their names, geoms ``sphere_i`` and ``object_i``, and a site ``tip``."""
    assert robot.shape is not None
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    links, site = _add_chain(spec, robot)
    links[-1].add_site(name="tip", pos=site[:3, 3], quat=_quaternion(site[:3, :3]))

    for number, capsule in enumerate(robot.shape.capsules):
        links[capsule.link].add_geom(
            name=f"sphere_{number}",
            type=mujoco.mjtGeom.mjGEOM_SPHERE,
            size=(capsule.radius, 0.0, 0.0),
            pos=capsule.start,
        )
    for number, solid in enumerate(problem.solids):
        if solid.kind == "box":
            kind, size = mujoco.mjtGeom.mjGEOM_BOX, np.array(solid.size) / 2
        else:
            length, radius = solid.size
            kind, size = mujoco.mjtGeom.mjGEOM_CYLINDER, np.array((radius, length / 2, 0.0))
        spec.worldbody.add_geom(
            name=f"object_{number}",
            type=kind,
            size=size,
            pos=solid.position,
            quat=solid.orientation,
        )
    return spec


def _add_chain(spec: mujoco.MjSpec, robot: Robot) -> tuple[list[Any], Array]:
    """The links, the base first, and where the tip is on the last one, ``(4, 4)``."""
    chain = robot.chain
    frames = chain.frames(torch.zeros(len(chain.names), dtype=torch.float64)).numpy()
    links, before = [spec.worldbody], np.eye(4)
    for number, name in enumerate(chain.names):
        # A body where the joint is while all are at 0.
        own = np.linalg.inv(before) @ frames[number]
        link = links[-1].add_body(pos=own[:3, 3], quat=_quaternion(own[:3, :3]))
        joint = link.add_joint(name=name, axis=chain.axes[number].tolist())
        low, high = float(chain.low[number]), float(chain.high[number])
        if math.isfinite(low) and math.isfinite(high):
            joint.limited, joint.range = mujoco.mjtLimited.mjLIMITED_TRUE, [low, high]

        # MuJoCo wants a mass, and kinematics do not.
        link.mass, link.inertia = 1.0, [0.01, 0.01, 0.01]
        link.explicitinertial = True
        links.append(link)
        before = frames[number]
    return links, np.linalg.inv(before) @ frames[-1]


def _quaternion(rotation: Array) -> Array:
    """The quaternion (w, x, y, z) of a rotation."""
    quaternion: Array = Rotation.from_matrix(rotation).as_quat(scalar_first=True)
    return quaternion
