"""Options of reaching, and its presets: ours and the baselines."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import torch

from aicon_torch.control import ActionLaw, DirectDescent
from aicon_torch.dampers import PlaceEscape, VelocityDampers
from aicon_torch.parts.hinge import SquaredHinge
from aicon_torch.parts.robot import Robot
from aicon_torch.parts.tip_pose import Orientation
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


@dataclass(frozen=True)
class Options:
    """Options of reaching.

    Attributes:
        robot: The arm: a URDF or a :class:`Robot`.
        tip: The link of the URDF that reaches; may be left out if the robot does not branch and has
            no gripper.
        srdf: Says which links of the URDF need not be compared.
        orientation: ``"free"`` for a position, ``"axis"`` for a position and an approach direction,
            ``"full"`` for a pose.
        axis: The axis of the tip that ``"axis"`` turns, a unit vector in its frame; of ``"full"``
            the one along which its tool approaches.
        resolution: What happens where gradients meet.
        law: From the gradient to the action.
        dampers: How joint limits and self-collision are kept.
        safety: Whether they are safety goals, which nothing violates, or goals like any other.
        joint_limits: Its margin is how far from its limits a joint stays, rad.
        self_collision: Its margin is how far links stay from each other, m.
        balls: Number of balls that are seen, still or moving, and not to be touched.
        ball_radius: Their radius, m.
        obstacles: Number of objects that are seen, of any shape and place, and not to be touched:
            see :class:`aicon_torch.parts.Solid`.
        dtype: Precision of the estimates.
        dt: Time step, s.
        speed: Largest speed of a joint, rad/s; None for those of the robot.
        lever: A rotation by one rad counts as much as a motion of the tip by this, m.
        damping: Of the pseudo-inverse of the Jacobian, m/rad.
        turns_within: Turns of the tip wait until its target is about so near, m: see
            :class:`aicon_torch.parts.EndEffector`. None where they do not.
        advances_within: Once the direct way has been found closed, an advance along the axis of the
            tool waits until the tip is about so near beside it, m: see
            :class:`aicon_torch.parts.ToolAxis`. None where it does not wait; a target of free
            orientation has no such axis.
        arrives_within: The tip slows down where it would come past its target in the time in which
            a joint at its limit goes this way, rad: see :class:`aicon_torch.parts.arrive.Arrive`.
        tolerance: Within which a target asks for nothing, m.
        watchdog: Whether the arm stops on readings that are too old, and on joints that are frozen.
    """

    robot: Robot | str | Path | None = None
    tip: str | None = None
    srdf: str | Path | None = None
    orientation: Orientation = "free"
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)
    resolution: Resolution = field(default_factory=NullspaceProjection)
    law: ActionLaw = field(default_factory=lambda: DirectDescent(smoothing=0.0))
    dampers: VelocityDampers = field(default_factory=lambda: VelocityDampers(haste=2.0))
    safety: bool = True
    joint_limits: SquaredHinge = field(default_factory=lambda: SquaredHinge(0.02, 1.0))
    self_collision: SquaredHinge = field(default_factory=lambda: SquaredHinge(0.01, 1.0))
    balls: int = 0
    ball_radius: float = 0.08
    obstacles: int = 0
    dtype: torch.dtype = torch.float64
    dt: float = 0.02
    speed: float | None = None
    lever: float = 0.2
    damping: float = 0.15
    turns_within: float | None = None
    advances_within: float | None = None
    arrives_within: float = 0.15
    tolerance: float = 0.001
    watchdog: bool = True

    def __post_init__(self) -> None:
        """Check what the parts do not check themselves.

        Raises:
            OptionError: If an option is not what it may be.
        """
        check_choice(self, "orientation", ("free", "axis", "full"))
        check_positive(self, ("dt", "lever", "damping", "ball_radius", "arrives_within"))
        check_not_negative(self, ("tolerance",))
        check_count(self, ("balls", "obstacles"))
        optional = ("speed", "turns_within", "advances_within")
        check_positive(self, [name for name in optional if getattr(self, name) is not None])
        margins = ("joint_limits", "self_collision")
        check_instance(self, margins, SquaredHinge, "SquaredHinge(0.02, 1.0)")
        check_flags(self)
        numbers("axis", self.axis, 3)


# Limits as goals like any other need wider margins; these were the best of a search.
_AS_GOALS = {
    "safety": False,
    "joint_limits": SquaredHinge(0.1, 1.0),
    "self_collision": SquaredHinge(0.05, 1.0),
}

PRESETS: Mapping[str, Mapping[str, Any]] = {
    "aicon": {},
    "clutter": {
        "dampers.braking": 0.15,
        "dampers.sweeps": None,
        "dampers.haste": 1.0,
        "dampers.escape": PlaceEscape(whole=(1, 3), looks_ahead=True),
        "self_collision": SquaredHinge(0.0025, 1.0),
        "damping": 0.05,
        "turns_within": 0.2,
        "advances_within": 0.28,
    },
    "without_escape": {"dampers.escape": None},
    "steepest": {**_AS_GOALS, "resolution": SteepestPath()},
    "potential_field": {**_AS_GOALS, "resolution": Sum()},
}
"""Options by preset: ours, ours among obstacles that leave little room, ours without the escape,
and the baselines, for which joint limits and self-collision are goals like any other."""
