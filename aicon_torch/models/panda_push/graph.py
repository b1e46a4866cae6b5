"""Pushing with an arm (Sect. "Real-World Transfer: Handling Additional Goal Conflicts").

The contact-based dynamics model of pushT is imported from there and works in its units: metres of the table become
pixels at 600 to the metre, which makes the T of both worlds the same. Added to it are the joints, the kinematics and
the goals of height, joint limits and self-collision. All gradients reach the joints through the kinematics.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Literal

import numpy as np
import torch
from torch import Tensor

from aicon_torch.errors import OptionError
from aicon_torch.estimation import EKF, Estimator, Deterministic, KalmanFilter
from aicon_torch.estimation import Measurement
from aicon_torch.goals import Goal
from aicon_torch.graph import WorldModel
from aicon_torch.interconnections import Affine, Interconnection
from aicon_torch.models.mechanism import Mechanism
from aicon_torch.parts.joint_limits import BodyFrames, JointLimits, SelfCollision, Workspace
from aicon_torch.parts.camera import LOOK, CameraFrame, Visibility, to_world
from aicon_torch.parts.chain import LEVER, EndEffector, Kinematics
from aicon_torch.models.panda_push.limits import ArmLimits
from aicon_torch.parts.image_registration import Registration
from aicon_torch.models.panda_push.robot import PANDA, Robot
from aicon_torch.models.panda_push.perception import BLOB, KEYPOINTS, SeeingPolicy
from aicon_torch.parts.touch import Felt, Resting, Touching
from aicon_torch.parts.contact import ContactLikelihood, closest_point, norm
from aicon_torch.parts.contact_dynamics import ContactDynamics
from aicon_torch.parts.contact_limits import ContactLimits, pose_error
from aicon_torch.parts.rigid_object import Outline
from aicon_torch.parts.pose import PoseMotion, same
from aicon_torch.control import Policy
from aicon_torch.quantities import Actuator, Sensor

SCALE = 600.0
"""px per m: the T is 0.2 m wide, that of pushT 120 px."""

T_CORNERS = (
    *((-0.1, -0.19 / 2.8), (0.1, -0.19 / 2.8), (0.1, -0.05 / 2.8), (0.025, -0.05 / 2.8)),
    *((0.025, 0.37 / 2.8), (-0.025, 0.37 / 2.8), (-0.025, -0.05 / 2.8), (-0.1, -0.05 / 2.8)),
)
"""Corners of the T about its centroid, m."""


@dataclass(frozen=True)
class Options(Mechanism):
    """Options of the arm's policy, besides those of the mechanism, which are pushT's.

    Those that pushT has, too, mean the same; lengths of the contact model are in px.

    Attributes:
        robot: The robot.
        corners: Corners of the object around its frame, m.
        sensing: Whether the object is seen by the camera, or its true pose is observed.
        dt: Time step, s.
        max_speed: Largest speed of the tip in the plane, m/s.
        joint_speed: Largest norm of the joints' velocities, rad/s.
        joint_noise: Standard deviation of an encoder, rad.
        pose_noise: Standard deviation of an observed pose, px.
        sight_noise: Standard deviation of a pose seen in the middle of the image, px.
        border: k, by which its variance grows toward the border: see :class:`Visibility`.
        blob_noise: Standard deviation of the object's centre about the middle of what is seen of it, px.
        trust: Score below which a registration is no reading.
        feel: Whether the force-torque sensor corrects the object's pose and height.
        place: Where the object is expected before it is seen, m.
        look: What serves to see better: see :data:`LOOK`.
        trace_weight: Weight of tr Σ in g₁, 1/px; 0 leaves it out.
        trace_tolerance: tr Σ that g₁ leaves alone, px²; 0 in the text.
        slip: Standard deviation of what moves the object in a second besides the model, px.
        rotation: L in radii of gyration.
        effect: What a contact does.
        reach: ℓ of contacts that help, px.
        reaction: ℓ' of contacts that harm, px.
        aim: How far outside its side a contact that helps is aimed at, px.
        facing: Whether harm at a corner counts as far as the side faces the pusher.
        speed_law: pushT's limits near contact, or none.
        horizon: Time over which they hold, s.
        slide_gap: Gap below which the tip is kept from sliding off a side, px.
        push: Least and largest push at a contact that helps within the horizon, px.
        harm: Largest push at one that harms, px.
        height: Height of the tip above the table, m.
        height_tolerance: Deviation from it that g₂ leaves alone, m; 0 in the text.
        tilt_tolerance: Tilt of the stick that the goal "upright" leaves alone, rad.
        settle: Least time to arrive at a height, s.
        limit_margin: m₀ of g₃, rad.
        limit_weight: w of g₃.
        collision_margin: d₀ of g₄, m.
        collision_weight: w of g₄.
        workspace_margin: m₀ of the goal "workspace", m.
        workspace_weight: w of it, px.
        goals: Which goals there are besides pushing.
        pullback: How a gradient goes from the end effector to the joints: see :class:`EndEffector`.
        damping: λ of the pseudo-inverse, m/rad.
    """

    robot: Robot = PANDA
    corners: Sequence[Sequence[float]] = T_CORNERS
    sensing: Literal["camera", "pose"] = "camera"
    dt: float = 0.01
    max_speed: float = 0.2
    joint_speed: float = 1.6
    joint_noise: float = 1e-4
    pose_noise: float = 0.1
    sight_noise: float = 0.5
    border: float = 100.0
    blob_noise: float = 30.0
    trust: float = 0.75
    feel: bool = True
    place: tuple[float, float] = (0.54, 0.0)
    look: Literal["heading", "orientation", "all"] = "heading"
    trace_weight: float = 0.1
    trace_tolerance: float = 4.0
    slip: float = 5.0
    rotation: float = 1.55
    effect: Literal["quasi_static", "sine", "angle"] = "quasi_static"
    reach: float = 30.0
    reaction: float = 10.0
    aim: float = 8.0
    facing: bool = True
    speed_law: Literal["contact", "none"] = "contact"
    horizon: float = 0.1
    slide_gap: float = 15.0
    push: tuple[float, float] = (0.5, 5.0)
    harm: float = 1.0
    height: float = 0.02
    height_tolerance: float = 0.001
    tilt_tolerance: float = 0.02
    settle: float = 0.2
    limit_margin: float = 0.1
    limit_weight: float = 300.0
    collision_margin: float = 0.05
    collision_weight: float = 30.0
    workspace_margin: float = 0.01
    workspace_weight: float = 60.0
    goals: Sequence[str] = ("heights", "upright", "workspace", "limits", "collisions")
    pullback: Literal["natural", "transpose"] = "natural"
    damping: float = 0.02

    def __post_init__(self) -> None:
        """Check what the parts do not check themselves."""
        for name, valid in _CHOICES.items():
            if getattr(self, name) not in valid:
                raise OptionError(f"{name}={getattr(self, name)!r}: expected one of {', '.join(map(repr, valid))}.")
        for goal in self.goals:
            if goal not in GOALS:
                raise OptionError(f"goals={tuple(self.goals)!r}: expected some of {', '.join(map(repr, GOALS))}.")


GOALS = ("heights", "upright", "workspace", "limits", "collisions")
"""g₂, two of ours, g₃ and g₄."""

_CHOICES = {
    "sensing": ("camera", "pose"),
    "effect": ("quasi_static", "sine", "angle"),
    "speed_law": ("contact", "none"),
    "resolution": ("nullspace", "sum", "steepest"),
    "pullback": ("natural", "transpose"),
    "look": tuple(LOOK),
}

PRESETS: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        "aicon": {},
        "transpose": {"pullback": "transpose"},
        "inherited": {"merge": "order"},
        "inherited_transpose": {"merge": "order", "pullback": "transpose"},
        "steepest": {"resolution": "steepest"},
        "potential_field": {"resolution": "sum"},
        "no_exploration": {"explore": False},
        "no_trace": {"trace_weight": 0.0},
        "more_trace": {"trace_weight": 1.0},
        "no_touch": {"feel": False},
        "no_upright": {"goals": ("heights", "workspace", "limits", "collisions")},
        "no_workspace": {"goals": ("heights", "upright", "limits", "collisions")},
        "no_limits": {"goals": ("heights", "upright", "workspace", "collisions")},
        "no_collisions": {"goals": ("heights", "upright", "workspace", "limits")},
        "no_workspace_limits_collisions": {"goals": ("heights", "upright")},
    }
)
"""Named options: ours, baselines, and ours without one part each, or with more of one."""


def world_model(options: Options) -> WorldModel:
    """The graph of the arm, of which that of pushT is a part."""
    outline = Outline.of([[SCALE * x, SCALE * y] for x, y in options.corners])
    length = options.rotation * outline.gyration
    dynamics = ContactDynamics(outline, length, options.effect)
    kinematics = Kinematics(options.robot, options.damping)
    sensors = {"z_joints": Sensor(7, "rad", key="q"), "z_target": Sensor(3, "m, m, rad", key="target")}
    if options.sensing == "pose":
        sensors["z_object"] = Sensor(3, "m, m, rad", key="object_pose", optional=True)
    else:
        sensors["z_ft"] = Sensor(6, "N, Nm", key="ft", range=(-100.0, 100.0))
        sensors[KEYPOINTS] = Sensor(3 * len(options.corners), "m", optional=True)
        sensors[BLOB] = Sensor(3, "m", optional=True)
        sensors["z_age"] = Sensor(1, "s", key="image_age")
    actuator = Actuator(7, "rad/s", limit=options.joint_speed, constraints=[_limits(options, kinematics, dynamics)])
    return WorldModel(
        sensors=sensors,
        actuators={"a": actuator},
        estimators=[
            *_arm(options, kinematics),
            *_object(options, outline, dynamics),
            Deterministic("x_target", Interconnection(lambda z: outline.center_at(in_pixels(z)), inputs=["z_target"])),
            Deterministic("x_side", outline.sides),
            Deterministic("x_contact", closest_point, each=["x_side"]),
            Deterministic("p_contact", _likelihood(options), each=["x_side", "x_contact"]),
            Deterministic("x_obj", dynamics),
        ],
        goals=[Goal("push", _pushing(options, length)), *_goals(options)],
        dt=options.dt,
        dtype=options.dtype,
    )


def points_of(z_keypoints: Tensor) -> Tensor:
    """The keypoints of a reading ``(*B, 3N)``, ``(*B, N, 3)``."""
    return z_keypoints.reshape(*z_keypoints.shape[:-1], -1, 3)


def beyond(cost: Tensor, tolerance: float) -> Tensor:
    """By what a cost ``(*B,)`` exceeds a tolerance: within it the goal asks for nothing."""
    return (cost - tolerance).clamp(min=0.0)


def in_pixels(pose: Tensor) -> Tensor:
    """A pose (x, y, θ) ``(*B, 3)`` in m and rad, in px and rad."""
    return torch.cat((SCALE * pose[..., :2], pose[..., 2:]), dim=-1)


def _arm(options: Options, kinematics: Kinematics) -> list[Estimator]:
    """Joints, end effector, and the stick as the pusher of pushT."""
    robot = options.robot
    seen = Measurement(Affine(x_joints=1.0, z_joints=-1.0), options.joint_noise**2, size=7)
    middle = tuple((low + high) / 2 for low, high in zip(robot.low, robot.high, strict=True))
    joints = KalmanFilter(
        "x_joints",
        "P_joints",
        predict=Affine(x_joints=1.0, a=options.dt),
        noise=1e-6,
        initial=(middle, 10.0),
        correct=[seen],
    )

    def velocity(x_joints: Tensor, a: Tensor) -> Tensor:
        jacobian = kinematics.jacobian(kinematics.frames(x_joints.detach()))  # what moved the object is past
        return SCALE * (jacobian[..., :2, :] @ a.detach().unsqueeze(-1)).squeeze(-1)

    arm: list[Estimator] = [
        joints,
        Deterministic("x_ee", EndEffector(kinematics, options.pullback)),
        Deterministic("x_pusher", lambda x_ee: SCALE * x_ee[..., :2]),
        Deterministic("v_pusher", velocity),
    ]
    if options.sensing == "pose":
        arm.append(Deterministic("x_heights", lambda x_ee: SCALE * (x_ee[..., 2:3] - options.height)))
    else:
        arm.append(Deterministic("x_cam", CameraFrame(robot, options.look)))
        arm.append(Deterministic("x_force", Felt(robot.tool_mass, robot.stick_length)))
        arm.append(_top(options))
        arm.append(Deterministic("x_heights", lambda x_ee, x_top: SCALE * (x_ee[..., 2:3] - x_top + options.height)))
    if "collisions" in options.goals:
        arm.append(Deterministic("x_body", BodyFrames(kinematics, robot)))
    return arm


def _object(options: Options, outline: Outline, dynamics: ContactDynamics) -> list[Estimator]:
    """The object's pose, and its keypoints there."""
    motion = PoseMotion(dynamics, SCALE * options.robot.stick_radius)
    if options.sensing == "camera":
        return _seen_object(options, outline, motion)

    def seen(x_pose: Tensor, z_object: Tensor) -> Tensor:
        return pose_error(x_pose, outline.center_at(in_pixels(z_object)), 1.0)

    def prior(z_object: Tensor) -> tuple[Tensor, Tensor]:
        return outline.center_at(in_pixels(z_object)), torch.eye(3, dtype=z_object.dtype, device=z_object.device)

    noise = options.pose_noise**2
    reading = Interconnection(seen, None, x_pose=lambda z_object: same(z_object))
    pose = _moving_pose(
        options,
        outline,
        motion,
        initial=prior,
        size=3,
        correct=[Measurement(reading, (noise, noise, noise / outline.gyration**2), size=3)],
    )
    return [pose, Deterministic("x_keypoints", Interconnection(outline.placed, inputs=["x_pose"]))]


def _moving_pose(options: Options, outline: Outline, motion: PoseMotion, **readings: Any) -> EKF:
    """x_pose: predicted from what the tip has pushed; how it begins and is corrected is the caller's matter."""
    slip = options.slip**2 * options.dt
    return EKF(
        "x_pose",
        "P_pose",
        predict=Interconnection(
            motion, ["x_pose", "x_pusher", "v_pusher", "dt"], x_pose=lambda x_pusher: same(x_pusher)
        ),
        noise=(slip, slip, slip / outline.gyration**2),
        **readings,
    )


def _seen_object(options: Options, outline: Outline, motion: PoseMotion) -> list[Estimator]:
    """The object's pose as the camera shows it, its keypoints, and how uncertain it is from there."""
    variance, middle = options.sight_noise**2, (SCALE * options.place[0], SCALE * options.place[1], 0.0)
    turn = variance / outline.gyration**2
    visibility = Visibility(options.robot, SCALE, (variance, variance, turn), options.border, 2 * options.height)

    def seen(x_pose: Tensor, z_keypoints: Tensor, x_cam: Tensor) -> Tensor:
        points = to_world(x_cam.detach(), points_of(z_keypoints))  # a reading leads no gradient anywhere
        return pose_error(x_pose, outline.pose(SCALE * points[..., :2]), 1.0)

    def part(x_pose: Tensor, z_blob: Tensor, x_cam: Tensor) -> Tensor:
        return x_pose[..., :2] - SCALE * to_world(x_cam.detach(), z_blob.unsqueeze(-2))[..., 0, :2]

    def position(z_blob: Tensor) -> Tensor:
        return torch.eye(3, dtype=z_blob.dtype, device=z_blob.device)[:2]

    touching = Touching(outline, SCALE * options.robot.stick_radius)
    pose = _moving_pose(
        options,
        outline,
        motion,
        initial=(middle, (60.0**2, 100.0**2, 4.0)),
        correct=[
            Measurement(Interconnection(seen, None, x_pose=lambda z_keypoints: same(z_keypoints)), visibility, size=3),
            Measurement(Interconnection(part, None, x_pose=position), options.blob_noise**2, size=2),
            *([Measurement(touching, touching.variance, size=1)] if options.feel else []),
        ],
    )
    return [pose, Deterministic("x_keypoints", Interconnection(outline.placed, inputs=["x_pose"]))]


def _top(options: Options) -> Estimator:
    """x_top: height of the object's top face, m, from the depth of its keypoints."""

    def level(x_top: Tensor, z_keypoints: Tensor, x_cam: Tensor) -> Tensor:
        points = to_world(x_cam.detach(), points_of(z_keypoints))  # a reading leads no gradient anywhere
        return x_top - points[..., 2].mean(-1, keepdim=True)

    resting = Resting()

    def one(z_keypoints: Tensor) -> Tensor:
        return torch.ones(1, 1, dtype=z_keypoints.dtype, device=z_keypoints.device)

    return EKF(
        "x_top",
        "P_top",
        predict=Affine(x_top=1.0),
        noise=1e-9,
        initial=((2 * options.height,), 1e-4),
        correct=[
            Measurement(Interconnection(level, None, x_top=one), 1e-6, size=1),
            *([Measurement(Interconnection(resting), resting.variance, size=1)] if options.feel else []),
        ],
    )


def _pushing(options: Options, length: float) -> Callable[..., Tensor]:
    """g₁ = ‖x_obj − x_target‖ + tr Σ_obj, with the angle as a length."""

    def distance(x_obj: Tensor, x_target: Tensor) -> Tensor:
        return norm(pose_error(x_obj, x_target, length))

    def with_trace(x_obj: Tensor, x_target: Tensor, P_pose: Tensor) -> Tensor:
        x, y, angle = P_pose.diagonal(dim1=-2, dim2=-1).unbind(-1)
        trace = beyond(x + y + length**2 * angle, options.trace_tolerance)
        return distance(x_obj, x_target) + options.trace_weight * trace

    return with_trace if options.sensing == "camera" and options.trace_weight else distance


def _likelihood(options: Options) -> Callable[..., Tensor]:
    radius = SCALE * options.robot.stick_radius
    return ContactLikelihood(options.reach, options.reaction, options.aim, options.facing, radius)


def _goals(options: Options) -> list[Goal]:
    """The goals besides pushing; those of the end effector are in px."""
    parts: dict[str, Callable[..., Tensor]] = {
        "heights": lambda x_heights: beyond(norm(x_heights), SCALE * options.height_tolerance),
        "upright": lambda x_ee: SCALE * beyond(norm(x_ee[..., 3:5]), LEVER * options.tilt_tolerance),
        "limits": JointLimits(options.robot, options.limit_margin, options.limit_weight),
        "collisions": SelfCollision(options.robot, options.collision_margin, options.collision_weight),
        "workspace": Workspace(options.robot, options.workspace_margin, options.workspace_weight),
    }
    return [Goal(name, parts[name]) for name in GOALS if name in options.goals]


def _limits(options: Options, kinematics: Kinematics, dynamics: ContactDynamics) -> ArmLimits:
    contact = None
    if options.speed_law == "contact":
        least, largest = options.push
        radius = SCALE * options.robot.stick_radius
        contact = ContactLimits(dynamics, None, (least, largest), options.harm, options.slide_gap, radius=radius)
    return ArmLimits(options.robot, kinematics, contact, SCALE, options.max_speed, options.horizon, options.settle)


def build(options: Options) -> Policy:
    """The arm's policy."""
    model, rule, law = world_model(options), options.rule(), options.law()
    if options.sensing == "pose":
        return Policy(model, rule, law)
    registration = Registration(np.array(options.corners, dtype=np.float64), options.robot.intrinsics)
    kinematics = Kinematics(options.robot)
    return SeeingPolicy(model, rule, law, registration, kinematics, options.robot, SCALE, options.trust)
