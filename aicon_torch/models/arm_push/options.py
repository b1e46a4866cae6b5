"""Options of the arm's policy, and its presets."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, get_args

import torch

from aicon_torch.control import ActionLaw, Foresight
from aicon_torch.errors import OptionError
from aicon_torch.models.arm_push.robot import PANDA, PushingRobot
from aicon_torch.parts.camera import Steering
from aicon_torch.parts.contact_options import ContactOptions
from aicon_torch.parts.end_effector import Pullback
from aicon_torch.parts.hinge import SquaredHinge
from aicon_torch.parts.servo import PARTS
from aicon_torch.resolution import NullspaceProjection, Resolution, SteepestPath, Sum
from aicon_torch.validation import (
    check_choice,
    check_count,
    check_flags,
    check_instance,
    check_not_negative,
    check_positive,
    numbers,
)

Sensing = Literal["camera", "pose"]
"""Whether the object is seen by the camera in the hand, or its true pose is observed."""

T_CORNERS: tuple[tuple[float, float], ...] = (
    (-0.1, -0.19 / 2.8),
    (0.1, -0.19 / 2.8),
    (0.1, -0.05 / 2.8),
    (0.025, -0.05 / 2.8),
    (0.025, 0.37 / 2.8),
    (-0.025, 0.37 / 2.8),
    (-0.025, -0.05 / 2.8),
    (-0.1, -0.05 / 2.8),
)
"""Corners of the T about its centroid, m."""

REACTION = 0.1
"""Time constant with which the joints' velocities follow their commands, s."""

LAW = Foresight(horizon=1.2 * REACTION, smoothing=0.0, dither=0.5, dither_steps=5)
"""What the action brings is foreseen until the joints have followed it. Their lag smooths it, and a
dither must last half of that time to be felt."""

CONTACT = ContactOptions(size=0.2, inset=1.0)
"""The contact model, as in pushT; only the T is larger, 0.2 m wide, and its sides are aimed at away
from their ends."""

RING = SquaredHinge(margin=0.03, weight=0.045)
"""Margin and weight (m) of the ring that keeps the object within reach: at its edge it pulls back
three times as strongly as a target far away pulls."""

JOINT_LIMITS = SquaredHinge(margin=0.1, weight=0.5)
SELF_COLLISION = SquaredHinge(margin=0.05, weight=0.05)
WORKSPACE = SquaredHinge(margin=0.01, weight=0.1)
"""Margins (rad, m, m) and weights (m) of the goals that keep the arm from its limits."""


@dataclass(frozen=True)
class CameraOptions:
    """What the camera shows of the object, and what seeing it well is worth.

    Attributes:
        noise: Standard deviation of a position that is seen in the middle of the image, m.
        edge_growth: By how much its variance grows toward the edge of the image: see
            :class:`aicon_torch.parts.camera.Visibility`.
        steering: What moves in order to see better: see
            :class:`aicon_torch.parts.camera.CameraFrame`.
        trace_weight: Weight of tr Σ in the goal "push", 1/m; 0 leaves it out.
        trace_tolerance: tr Σ that this goal leaves alone, m²; 0 in the text.
        background: Whether images are read in a thread of their own, and no step waits for them:
            see :class:`aicon_torch.readings.BackgroundPerception`.
        delay: Largest age of an image that is made up for, steps; ages come as ``image_age``, s.
            With 0 an image is taken to show what is.
    """

    noise: float = 1 / 1200
    edge_growth: float = 100.0
    steering: Steering = "heading"
    trace_weight: float = 60.0
    trace_tolerance: float = (1 / 300) ** 2
    background: bool = False
    delay: int = 0

    def __post_init__(self) -> None:
        """Check the numbers.

        Raises:
            OptionError: If one is not what it may be.
        """
        check_count(self, ("delay",), "number of steps")
        check_positive(self, ("noise",))
        check_not_negative(self, ("edge_growth", "trace_weight", "trace_tolerance"))
        check_choice(self, "steering", get_args(Steering))
        check_flags(self)


@dataclass(frozen=True)
class Options:
    """Options of the arm's policy; a preset or a user names nested ones by a dotted path.

    Attributes:
        resolution: What happens where gradients meet.
        law: From the gradient to the action.
        dtype: Precision of the estimates.
        dt: Time step, s.
        robot: The robot.
        corners: Corners of the object around its frame, m.
        sensing: What is known of the object.
        camera: How it is seen, if it is.
        touch: Whether the wrist feels it, if it is seen.
        contact: The contact model, which is pushT's.
        pose_noise: Standard deviation of a pose that is observed, m.
        pose_offset: By how much it is off every time, (x, y, θ), m and rad.
        drift: Standard deviation of what moves the object in a second besides the model, m.
        stick_friction: Coefficient of friction between stick and object, with which its
            motion is predicted; 0 predicts without.
        expected_place: Where the object is expected before it is seen, (x, y), m.
        height: Height of the tip above the table, half the thickness of the object, m.
        height_tolerance: Deviation from it that the goal "height" leaves alone, m; 0 in the text.
        upright_tolerance: Tilt of the stick that the goal "upright" leaves alone, rad; None leaves
            the goal out, as the text does.
        workspace: The goal that keeps the tip from the edge of the workspace, margin in m; None
            leaves it out, as the text does.
        ring: What pushing costs besides where the object leaves the ring around which the stick
            gets, margin in m: see :class:`aicon_torch.models.arm_push.goals.Ring`; None leaves it
            out, as the text does.
        joint_limits: The goal g₃, margin in rad; None leaves it out.
        self_collision: The goal g₄, margin in m; None leaves it out.
        lever: A rotation of the end effector by one rad counts as much as a motion by this, m.
        pullback: How a gradient goes from the end effector to the joints: see
            :class:`aicon_torch.parts.end_effector.EndEffector`.
        damping: λ of the pseudo-inverse there, m/rad.
        delay: Largest age of encoders and of an observed pose that is made up for, steps; ages come
            as ``age``, s, and are this one where they do not.
        watchdog: Whether the arm stops on readings that are too old or frozen.
    """

    resolution: Resolution = field(default_factory=NullspaceProjection)
    law: ActionLaw = LAW
    dtype: torch.dtype = torch.float64
    dt: float = 0.01

    robot: PushingRobot = PANDA
    corners: Sequence[Sequence[float]] = T_CORNERS

    sensing: Sensing = "camera"
    camera: CameraOptions = CameraOptions()
    touch: bool = True
    pose_noise: float = 1 / 6000
    pose_offset: Sequence[float] = (0.0, 0.0, 0.0)
    drift: float = 1 / 40
    stick_friction: float = 0.2
    expected_place: tuple[float, float] = (0.54, 0.0)

    contact: ContactOptions = CONTACT

    height: float = 0.02
    height_tolerance: float = 0.001
    upright_tolerance: float | None = 0.02
    workspace: SquaredHinge | None = WORKSPACE
    ring: SquaredHinge | None = RING
    joint_limits: SquaredHinge | None = JOINT_LIMITS
    self_collision: SquaredHinge | None = SELF_COLLISION

    lever: float = 0.2
    pullback: Pullback = "natural"
    damping: float = 0.02
    delay: int = 0
    watchdog: bool = True

    @property
    def parts(self) -> int:
        """In how many parts a motion of the tip is followed: those of a step are short."""
        return 1 if self.law.horizon is None else PARTS

    @property
    def is_late(self) -> bool:
        """Whether readings that are late are made up for."""
        return bool(self.delay or self.camera.delay)

    def __post_init__(self) -> None:
        """Check what the parts do not check themselves.

        Raises:
            OptionError: If one is not what it may be.
        """
        check_choice(self, "sensing", get_args(Sensing))
        check_choice(self, "pullback", get_args(Pullback))
        check_positive(self, ("dt", "pose_noise", "drift", "height", "lever", "damping"))
        check_not_negative(self, ("height_tolerance", "stick_friction"))
        numbers("pose_offset", self.pose_offset, 3)
        numbers("expected_place", self.expected_place, 2)
        if self.upright_tolerance is not None:
            check_not_negative(self, ("upright_tolerance",))
        check_count(self, ("delay",), "number of steps")
        check_instance(self, ("law",), ActionLaw, "Foresight()")
        check_instance(self, ("camera",), CameraOptions, "CameraOptions()")
        check_instance(self, ("contact",), ContactOptions, "ContactOptions(size=0.2)")
        check_flags(self)

        # What takes a sentence of its own.
        if not isinstance(self.robot, PushingRobot):
            raise OptionError(
                f"robot={self.robot!r}: expected a PushingRobot, such as "
                "PushingRobot.from_description(env.unwrapped.description())."
            )


PRESETS: Mapping[str, Mapping[str, Any]] = {
    "aicon": {},
    "steepest": {"resolution": SteepestPath()},
    "potential_field": {"resolution": Sum()},
}
"""Options by preset: ours, the steepest path (Eq. 2), and plain backpropagation."""
