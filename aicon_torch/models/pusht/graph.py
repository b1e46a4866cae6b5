"""Pushing an object to a target pose (Sect. "pushT: Object Pushing in Simulation").

A disc pushes a polygon of which it sees the corners. For each side of the polygon two gradients lead from the pose
error to the pusher: p₁ through the likelihood of a contact there, p₂ through its position. The world is that of
gym-pusht: pixels, with y pointing down, and a PD controller that moves the pusher to position targets.

What is ours beyond the text is an option of its own: likelihoods that differ for contacts that help and contacts that
harm, the quasi-static effect of a contact, magnitudes relative to the largest, conflicts with any opposing gradient,
and limits of the motion near contact.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Literal

import torch
from torch import Tensor

from aicon_torch.errors import OptionError
from aicon_torch.estimation import EKF, Estimator, Deterministic, KalmanFilter
from aicon_torch.estimation import Measurement
from aicon_torch.goals import Goal
from aicon_torch.graph import WorldModel
from aicon_torch.interconnections import Affine, Interconnection
from aicon_torch.models.mechanism import Mechanism
from aicon_torch.parts.contact import ContactLikelihood, closest_point, held_point, norm
from aicon_torch.parts.delay import ActionHistory, LatePoseMotion, PoseNow, now, then
from aicon_torch.parts.contact_dynamics import ContactDynamics
from aicon_torch.parts.contact_limits import ContactLimits, SlowApproach, pose_error
from aicon_torch.parts.rigid_object import Outline, numbers
from aicon_torch.parts.pose import PoseMotion, Registration, rest, same
from aicon_torch.parts.servo import WORKSPACE, Servo
from aicon_torch.control import Policy
from aicon_torch.quantities import Actuator, Sensor


@dataclass(frozen=True)
class Options(Mechanism):
    """Options of the pushing policy, besides those of the mechanism.

    Attributes:
        keypoints: Corners of the object in its body frame, in the order of the sensor, px; None for the T.
        border: Their order around the object; by default as given.
        center: Centre of mass in the body frame, px; by default the polygon's.
        gyration: Radius of gyration, px; by default the polygon's.
        goal_pose: Target of the body frame (x, y, θ), px and rad.
        observe_goal: Whether the target is observed instead, as ``goal_pose``.
        dt: Time step, s; a multiple of the PD controller's sub-step of 0.01 s.
        max_speed: Largest speed, px/s.
        command: Whether the action is sent as the PD controller's position target or as the velocity itself.
        servo: Whether the position target takes the controller's lag into account.
        keypoint_noise: Standard deviation of each coordinate of a keypoint, px.
        pusher_noise: Standard deviation of each coordinate of the pusher's position, px.
        slip: Standard deviation of each coordinate of what moves pusher and object in a step besides the model, px.
        estimation: Whether pusher and object are filtered, or read off the sensors.
        delay: Age of every reading, steps; without estimation readings are taken as they come.
        rotation: L in radii of gyration: a rotation of one rad counts as much as a translation by L.
        effect: What a contact does: see :class:`ContactDynamics`.
        reach: ℓ of the likelihood of contacts that help, px.
        reaction: ℓ' of the likelihood of contacts that harm, px.
        aim: How far outside its side a contact that helps is aimed at, px.
        facing: Whether harm at a corner counts as far as the side faces the pusher.
        intent: T of the soft choice between the two likelihoods; 0 chooses by the sign of a contact's gain.
        likelihood_path: Whether p₁ is there.
        position_path: Whether p₂ is there.
        speed_law: Limits near contact, a slow approach, or none.
        slide_gap: Gap below which the pusher is kept from sliding off a side, px; 0 never.
        substeps: Whether the limits hold within a step, too.
        push: Least and largest push at a contact that helps, px.
        harm: Largest push at one that harms, px.
    """

    keypoints: Sequence[Sequence[float]] | None = None
    border: Sequence[int] | None = None
    center: Sequence[float] | None = None
    gyration: float | None = None
    goal_pose: Sequence[float] = (256.0, 256.0, math.pi / 4)
    observe_goal: bool = False
    dt: float = 0.1
    max_speed: float = 800.0
    command: Literal["position", "velocity"] = "position"
    servo: bool = True
    keypoint_noise: float = 0.1
    pusher_noise: float = 0.1
    slip: float = 0.5
    estimation: bool = True
    delay: int = 0
    rotation: float = 1.55
    effect: Literal["quasi_static", "sine", "angle"] = "quasi_static"
    reach: float = 30.0
    reaction: float = 10.0
    aim: float = 8.0
    facing: bool = True
    intent: float = 0.0
    likelihood_path: bool = True
    position_path: bool = True
    speed_law: Literal["contact", "slow", "none"] = "contact"
    slide_gap: float = 15.0
    substeps: bool = True
    push: tuple[float, float] = (0.5, 40.0)
    harm: float = 2.0

    def __post_init__(self) -> None:
        """Check what the parts do not check themselves."""
        noises = ("keypoint_noise", "pusher_noise", "slip")
        for name in ("dt", "max_speed", *noises, "rotation", "reach", "reaction"):
            if not numbers(name, getattr(self, name), 1)[0] > 0:
                raise OptionError(f"{name}={getattr(self, name)!r}: expected a positive number.")
        for name in ("aim", "intent", "slide_gap", "harm"):
            if not numbers(name, getattr(self, name), 1)[0] >= 0:
                raise OptionError(f"{name}={getattr(self, name)!r}: expected a number >= 0.")
        if not (type(self.delay) is int and self.delay >= 0):
            raise OptionError(f"delay={self.delay!r}: expected a number of steps >= 0.")
        if abs(self.dt / 0.01 - round(self.dt / 0.01)) > 1e-6 or self.dt < 0.01:
            raise OptionError(f"dt={self.dt!r}: expected a multiple of 0.01 s, the PD controller's sub-step.")
        for name, valid in _CHOICES.items():
            if getattr(self, name) not in valid:
                raise OptionError(f"{name}={getattr(self, name)!r}: expected one of {', '.join(map(repr, valid))}.")
        numbers("goal_pose", self.goal_pose, 3)
        least, largest = numbers("push", self.push, 2)
        if not 0 <= least <= largest:
            raise OptionError(f"push={self.push!r}: expected (least, largest) in px.")


_CHOICES = {
    "command": ("position", "velocity"),
    "effect": ("quasi_static", "sine", "angle"),
    "speed_law": ("contact", "slow", "none"),
    "resolution": ("nullspace", "sum", "steepest"),
}

_FULL = {
    "effect": "sine",
    "rotation": 65.0 / 3000**0.5,
    "reach": 40.0,
    "facing": False,
    "speed_law": "slow",
    "servo": False,
    "max_speed": 600.0,
    "smoothing": 0.025,
}
_STRICT = {**_FULL, "by_row": False, "partner": "second"}
_SYMMETRIC = {"aim": 0.0, "facing": False}
_LITERAL = {
    **_STRICT,
    **_SYMMETRIC,
    "effect": "angle",
    "reach": 10.0,
    "relative": False,
    "speed_law": "none",
    "smoothing": 0.1,
}

PRESETS: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        "aicon": {},
        "full": _FULL,
        "strict": _STRICT,
        "paper_literal": _LITERAL,
        "steepest": {"resolution": "steepest"},
        "steepest_unlimited": {"resolution": "steepest", "speed_law": "none"},
        "potential_field": {"resolution": "sum"},
        "potential_field_unlimited": {"resolution": "sum", "speed_law": "none"},
        "intended": {"intent": 0.1},
        "symmetric_near": {**_SYMMETRIC, "reach": 10.0},
        "symmetric_far": {**_SYMMETRIC, "reaction": 30.0},
        "pass_through": {"estimation": False},
        "uniform_density": {"center": (0.0, 285.0 / 7), "gyration": 43.9447},
        "no_exploration": {"explore": False},
        "no_projection": {"projector": "none"},
        "no_softmax": {"temperature": None},
        "no_hysteresis": {"margin": 0.0},
        "no_smoothing": {"smoothing": 0.0},
        "no_position_path": {"position_path": False},
        "no_grouping": {"by_row": False},
        "no_facing": {"facing": False},
        "no_limits": {"speed_law": "none"},
        "no_slide_limit": {"slide_gap": 0.0},
        "no_substeps": {"substeps": False},
        "no_servo": {"servo": False},
        "second_partner": {"partner": "second"},
        "as_in_text": {"relative": False, "partner": "second", "ratio_of": "weights", "average_time": 1.0},
    }
)
"""Named options: ours, the baselines, and ours without one part each. Nearer to the text are

- ``full``: likelihoods of two ranges and any opposing partner, but the sine for the effect, a slow approach instead of
  limits, and position targets that leave the servo's lag to itself;
- ``strict``: besides, each path a candidate of its own, and the second strongest as partner;
- ``paper_literal``: besides, one likelihood for all contacts, the angle for the effect, the softmax over magnitudes as
  they are, and no speed law.

Gain and speed are the best of the same search for each policy (``scripts/tune.py --task pusht``).
"""


def seen_pusher(z_pusher: Tensor) -> tuple[Tensor, Tensor]:
    """The pusher's prior: at its first reading, give or take 10 px."""
    return z_pusher, 100.0 * torch.eye(2, dtype=z_pusher.dtype, device=z_pusher.device)


def world_model(options: Options) -> WorldModel:
    """The graph of the paper's pushT, with its paths p₁ and p₂ for each side."""
    outline = Outline.of(options.keypoints, options.border, options.center, options.gyration)
    length = options.rotation * outline.gyration
    servo = Servo.of(substeps=round(options.dt / 0.01))
    dynamics = ContactDynamics(outline, length, options.effect, options.intent)
    sensors = {
        "z_pusher": Sensor(2, "px", key="agent_pos", optional=True),
        "z_keypoints": Sensor(2 * len(outline.keypoints), "px", key="environment_state", optional=True),
    }
    if options.observe_goal:
        sensors["z_target"] = Sensor(3, "px, px, rad", key="goal_pose")
    command = None
    if options.command == "position":
        command = servo.target if options.servo else lagging_target
    actuator = Actuator(
        2, "px/s", limit=options.max_speed, constraints=_constraints(options, dynamics, servo), command=command
    )
    return WorldModel(
        sensors=sensors,
        actuators={"a": actuator},
        estimators=[
            *_pusher(options, servo),
            *_object(options, outline, dynamics),
            Deterministic("x_target", _target(options, outline)),
            Deterministic("x_side", outline.sides),
            Deterministic("x_contact", closest_point if options.position_path else held_point, each=["x_side"]),
            Deterministic("p_contact", _likelihood(options), each=["x_side", "x_contact"]),
            Deterministic("x_obj", dynamics),
        ],
        goals=[Goal("push", lambda x_obj, x_target: norm(pose_error(x_obj, x_target, length)))],
        dt=options.dt,
        dtype=options.dtype,
    )


def lagging_target(a: Tensor, x_pusher: Tensor, dt: float) -> Tensor:
    """The position target as if the pusher followed at once, ``(*B, 2)``, px."""
    return (x_pusher + a * dt).clamp(0.0, WORKSPACE)


def _pusher(options: Options, servo: Servo) -> list[Estimator]:
    """The pusher's position, and its velocity as the PD controller leaves it."""
    late = options.estimation and options.delay > 0
    name, covariance = ("y_pusher", "Q_pusher") if late else ("x_pusher", "P_pusher")
    noise = options.pusher_noise**2 if options.estimation else 1e-9
    position = EKF(
        name,
        covariance,
        predict=then if late else Affine(x_pusher=1.0, a=options.dt),
        noise=options.slip**2,
        initial=seen_pusher,
        size=2,
        correct=[Measurement(Affine(**{name: 1.0, "z_pusher": -1.0}), noise, size=2)],
    )
    change = Affine(v_pusher=0.0, a=1.0)  # a velocity that is commanded is there at once
    if options.command == "position":
        lag = servo.kick / servo.follow[-1]
        change = Affine(v_pusher=servo.keep - lag * servo.drift[-1], a=lag * options.dt)
    velocity = KalmanFilter("v_pusher", "P_velocity", predict=change, noise=1.0, initial=((0.0, 0.0), 1.0))
    if not late:
        return [position, velocity]
    return [ActionHistory(options.delay + 1), position, Deterministic("x_pusher", now), velocity]


def _object(options: Options, outline: Outline, dynamics: ContactDynamics) -> list[Estimator]:
    """The object's pose, and its keypoints there."""
    late = options.estimation and options.delay > 0
    name, covariance = ("y_pose", "Q_pose") if late else ("x_pose", "P_pose")
    register, motion = Registration(outline), PoseMotion(dynamics)
    predict = LatePoseMotion(motion) if late else motion if options.estimation else rest
    noise = register.variances(options.keypoint_noise if options.estimation else 1e-6)
    slip = options.slip**2
    slope: dict[str, Callable[..., Tensor]] = {name: same}
    pose = EKF(
        name,
        covariance,
        predict=Interconnection(predict, None, **slope),
        noise=(slip, slip, slip / outline.gyration**2),
        initial=register.prior,
        size=3,
        correct=[Measurement(Interconnection(register, [name, "z_keypoints"], **slope), noise, size=3)],
    )
    keypoints = Deterministic("x_keypoints", Interconnection(outline.placed, inputs=["x_pose"]))
    return [pose, Deterministic("x_pose", PoseNow(motion)), keypoints] if late else [pose, keypoints]


def _target(options: Options, outline: Outline) -> Interconnection:
    """x_target: centre and orientation of the object at the goal, observed or fixed, ``(*B, 3)``."""
    if options.observe_goal:
        return Interconnection(outline.center_at, inputs=["z_target"])
    fixed = outline.center_at(torch.tensor(tuple(options.goal_pose), dtype=torch.float64))
    return Interconnection(lambda x_pose: fixed.to(x_pose).expand_as(x_pose))


def _likelihood(options: Options) -> Callable[..., Tensor]:
    likelihood = ContactLikelihood(options.reach, options.reaction, options.aim, options.facing)
    if options.likelihood_path:
        return likelihood
    return lambda x_pusher, x_contact, x_side: likelihood(x_pusher.detach(), x_contact, x_side)  # without p1


def _constraints(options: Options, dynamics: ContactDynamics, servo: Servo) -> list[Callable[..., Tensor]]:
    if options.speed_law == "none":
        return []
    if options.speed_law == "slow":
        return [SlowApproach(dynamics.length)]
    within = servo if options.substeps and options.command == "position" else None
    return [ContactLimits(dynamics, within, (options.push[0], options.push[1]), options.harm, options.slide_gap)]


def build(options: Options) -> Policy:
    """The pushing policy."""
    return Policy(world_model(options), options.rule(), options.law())
