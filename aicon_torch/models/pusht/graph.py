"""Pushing an object to a target pose (Sect. "pushT: Object Pushing in Simulation").

A disc pushes a polygon of which it sees the corners. For each side of the polygon two gradients
lead from the pose error to the pusher: p₁ through the likelihood of a contact there, p₂ through its
position. The world is that of gym-pusht, with y pointing down and a PD controller that moves the
pusher to position targets; its px become metres at the sensors, and px again at the actuator.

What is ours beyond the text is an option of its own: likelihoods that differ for contacts that help
and contacts that harm, the quasi-static effect of a contact, magnitudes relative to the largest,
conflicts with any opposing gradient, and an action law that looks ahead.
"""

from collections.abc import Callable

import torch
from torch import Tensor

from aicon_torch.differentiation import stop
from aicon_torch.estimation import Deterministic, Estimator
from aicon_torch.goals import Goal
from aicon_torch.graph import WorldModel
from aicon_torch.interconnections import Interconnection
from aicon_torch.models.pusht.benchmark import PUSHER_RADIUS, SUBSTEP
from aicon_torch.models.pusht.interface import actuator, sensors
from aicon_torch.models.pusht.options import Options
from aicon_torch.models.pusht.picture import PicturePerception
from aicon_torch.models.pusht.pushed_object import object_estimators, rigid_object
from aicon_torch.models.pusht.pusher import motion_in_step, pusher_estimators
from aicon_torch.parts.contact import closest_point, fixed_closest_point
from aicon_torch.parts.pose import FixedTarget, PoseDistance
from aicon_torch.parts.rigid_object import RigidObject
from aicon_torch.parts.servo import Servo
from aicon_torch.policy import Policy
from aicon_torch.readings import Perception


def build(options: Options) -> Policy:
    """The pushing policy."""
    perception: Perception | None = None
    if options.picture is not None:
        perception = PicturePerception.load(options.picture, rigid_object(options))
    return Policy(world_model(options), options.resolution, options.law, perception)


def world_model(options: Options) -> WorldModel:
    """The graph of the paper's pushT, with its paths p₁ and p₂ for each side."""
    body = rigid_object(options)
    dynamics = options.contact.dynamics(body)
    servo = Servo.of(substep=SUBSTEP, substeps=options.substeps)

    return WorldModel(
        sensors=sensors(options, body),
        actuators={"a": actuator(options, servo)},
        estimators=[
            *pusher_estimators(options, servo),
            *object_estimators(options, dynamics, motion_in_step(options, servo).parts),
            _target(options, body),
            # A path for each side: p₁ leads over p_contact, p₂ over x_contact.
            *_contacts(options, body),
            Deterministic("x_obj", dynamics),
        ],
        goals=[Goal("push", PoseDistance(dynamics.rotation_length))],
        dt=options.dt,
        clock="z_elapsed" if options.command == "velocity" else None,
        dtype=options.dtype,
    )


def _target(options: Options, body: RigidObject) -> Deterministic:
    """x_target: the object's pose at the goal, observed or fixed."""
    if options.observe_goal:
        observed = Interconnection(body.pose_of_frame, inputs=["z_target"])
        return Deterministic("x_target", observed)

    frame = torch.tensor(tuple(options.goal_pose), dtype=torch.float64)
    return Deterministic("x_target", FixedTarget(body.pose_of_frame(frame)))


def _contacts(options: Options, body: RigidObject) -> list[Estimator]:
    """x_side, x_contact, p_contact: the sides, their closest points, how likely a contact is."""
    point = closest_point if options.position_path else fixed_closest_point
    return [
        Deterministic("x_side", body.sides),
        Deterministic("x_contact", point, each=["x_side"]),
        Deterministic("p_contact", _likelihood(options), each=["x_side", "x_contact"]),
    ]


def _likelihood(options: Options) -> Callable[..., Tensor]:
    """p_contact, with or without the path p₁."""
    likelihood = options.contact.likelihood(PUSHER_RADIUS)

    def fixed_likelihood(x_pusher: Tensor, x_contact: Tensor, x_side: Tensor) -> Tensor:
        return likelihood(stop(x_pusher), x_contact, x_side)  # stops p₁

    return likelihood if options.likelihood_path else fixed_likelihood
