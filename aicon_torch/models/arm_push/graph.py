"""Pushing with an arm (Sect. "Real-World Transfer: Handling Additional Goal Conflicts").

The contact-based dynamics model is that of pushT. Added to it are the joints, the kinematics and
the goals of height, joint limits and self-collision. All gradients reach the joints through the
kinematics.
"""

import copy
from collections.abc import Callable
from typing import Any

import numpy as np
from torch import Tensor

from aicon_torch.estimation import Deterministic, Estimator
from aicon_torch.goals import Goal
from aicon_torch.graph import WorldModel
from aicon_torch.models.arm_push.arm import HeightAtObject, HeightOverTable, arm, hand
from aicon_torch.models.arm_push.goals import CertainPush, PushWithinReach, Ring, off_height, tilt
from aicon_torch.models.arm_push.image_registration import ImageRegistration
from aicon_torch.models.arm_push.limits import JOINT_SPEED, TIP_SPEED, ArmLimits
from aicon_torch.models.arm_push.options import Options
from aicon_torch.models.arm_push.perception import BLOB, KEYPOINTS, SEEN_AGE, CameraPerception
from aicon_torch.models.arm_push.pushed_object import object_top, pushed_object
from aicon_torch.models.arm_push.scene import Scene
from aicon_torch.models.watched import prompt, watched
from aicon_torch.parts.clock import clock
from aicon_torch.parts.contact import closest_point
from aicon_torch.parts.joint_limits import JointLimits
from aicon_torch.parts.planar_dither import PlanarDither
from aicon_torch.parts.pose import PoseDistance
from aicon_torch.parts.self_collision import SelfCollision
from aicon_torch.parts.workspace import Workspace
from aicon_torch.policy import Policy
from aicon_torch.quantities import Actuator, Sensor
from aicon_torch.readings import BackgroundPerception, Perception

TURNS = (-10.0, 10.0)
"""Range of angles, rad, and of places on the table, m."""

SEEN = (-100.0, 100.0)
"""Range of what the camera shows, m."""

MAX_GAP = 5.0
"""Steps without a reading after which the arm slows down."""

JUMP = 3.0
"""How fast a joint's reading may change, in speed limits: it has noise."""


def build(options: Options) -> Policy:
    """The arm's policy."""
    perception: Perception | None = None
    if options.sensing == "camera":
        camera = camera_perception(options)
        perception = BackgroundPerception(camera) if options.camera.background else camera
    return Policy(world_model(options), options.resolution, options.law, perception=perception)


def camera_perception(options: Options) -> CameraPerception:
    """What turns the camera's images into readings."""
    robot = options.robot
    corners = np.array(options.corners, dtype=np.float64)
    registration = ImageRegistration(corners, robot.intrinsics)
    chain = copy.deepcopy(robot.chain)
    return CameraPerception(registration, chain, robot.camera, options.dt)


def world_model(options: Options) -> WorldModel:
    """The graph of the arm, of which that of pushT is a part."""
    scene = Scene.of(options)
    return WorldModel(
        sensors=_sensors(options),
        actuators={"a": _actuator(scene)},
        estimators=[*arm(scene), *_heights(scene), *pushed_object(scene), *_contacts(scene)],
        goals=_goals(scene),
        dt=options.dt,
        clock="z_elapsed",
        dtype=options.dtype,
    )


def _sensors(options: Options) -> dict[str, Sensor]:
    """Encoders and target, and either the pose of the object or the camera and the wrist."""
    # What the watchdog asks: how old a reading may be, how long there may be none, and how fast one
    # may change.
    gap = MAX_GAP if options.watchdog else None
    late = watched(options.dt, options.delay, gap)
    moving = dict(late)
    if options.watchdog:
        moving |= {"rate_limit": JUMP * float(options.robot.chain.speed.max()), "driven_by": "a"}

    # Always: the time, the encoders and the target.
    sensors = {
        "z_elapsed": clock(),
        "z_joints": Sensor(len(options.robot.chain.names), "rad", key="q", range=TURNS, **moving),
        "z_target": Sensor(3, "m, m, rad", key="target", range=TURNS, **prompt(options.dt, gap)),
    }

    # The object's pose, told ...
    if options.sensing == "pose":
        sensors["z_object"] = Sensor(
            3, "m, m, rad", key="object_pose", optional=True, range=TURNS, **late
        )
        return sensors

    # ... or seen by the camera in the hand, and felt at the wrist.
    sensors["z_ft"] = Sensor(6, "N, Nm", key="ft", range=(-1e3, 1e3))
    seen: dict[str, Any] = {"optional": True, "range": SEEN}
    if options.camera.delay:
        seen["age_key"] = SEEN_AGE
    sensors[KEYPOINTS] = Sensor(3 * len(options.corners), "m", **seen)
    sensors[BLOB] = Sensor(3, "m", **seen)
    sensors["z_age"] = Sensor(1, "s", key="image_age", range=(-1.0, 1e6))
    return sensors


def _actuator(scene: Scene) -> Actuator:
    """The velocities of the joints, within their limits and those of the tip."""
    chain = scene.options.robot.chain
    return Actuator(
        len(chain.names),
        "rad/s",
        limit=JOINT_SPEED,
        constraints=[ArmLimits(scene.end_effector, chain.speed.tolist())],
        key="executed",
        dither=PlanarDither(scene.end_effector, TIP_SPEED),
    )


def _heights(scene: Scene) -> list[Estimator]:
    """The height of the tip: at the object, where that is seen, or else over the table."""
    height = scene.options.height
    if scene.options.sensing == "pose":
        return [Deterministic("x_heights", HeightOverTable(height))]

    heights = Deterministic("x_heights", HeightAtObject(depth=height))
    return [*hand(scene), object_top(scene.options), heights]


def _contacts(scene: Scene) -> list[Estimator]:
    """The contact model of pushT: where a contact may be, how likely it is, and what it does."""
    likelihood = scene.options.contact.likelihood(scene.options.robot.stick_radius)
    return [
        Deterministic("x_side", scene.body.sides),
        Deterministic("x_contact", closest_point, each=["x_side"]),
        Deterministic("p_contact", likelihood, each=["x_side", "x_contact"]),
        Deterministic("x_obj", scene.dynamics),
    ]


def _goals(scene: Scene) -> list[Goal]:
    """Pushing, and the goals of the arm that the options ask for; all costs are in m."""
    options, robot = scene.options, scene.options.robot
    height = Goal("height", off_height, tolerance=options.height_tolerance)
    goals = [Goal("push", _push(scene)), height]

    # What an arm has to keep besides.
    if options.upright_tolerance is not None:
        most = options.lever * options.upright_tolerance
        goals.append(Goal("upright", tilt, tolerance=most))
    if options.workspace is not None:
        goals.append(Goal("workspace", Workspace(robot.reach, options.workspace)))
    if options.joint_limits is not None:
        limits = JointLimits(robot.chain.low, robot.chain.high, options.joint_limits)
        goals.append(Goal("joint_limits", limits))
    if options.self_collision is not None:
        collision = SelfCollision(robot.shape.capsules, options.self_collision, robot.shape.pairs)
        goals.append(Goal("self_collision", collision))
    return goals


def _push(scene: Scene) -> Callable[..., Tensor]:
    """g₁, with the uncertainty of an object that is seen."""
    length, camera = scene.dynamics.rotation_length, scene.options.camera
    cost = scene.options.ring
    ring = None if cost is None else Ring.within_reach(scene.options.robot, scene.body, cost)

    if scene.options.sensing == "camera" and camera.trace_weight > 0:
        return CertainPush(length, camera.trace_weight, camera.trace_tolerance, ring)
    return PoseDistance(length) if ring is None else PushWithinReach(length, ring)
