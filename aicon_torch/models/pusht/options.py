"""Options of the pushing policy, in SI units."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import torch

from aicon_torch.control import ActionLaw, Foresight
from aicon_torch.errors import OptionError
from aicon_torch.models.pusht.benchmark import GOAL_POSE, PIXEL, SUBSTEP, T_WIDTH
from aicon_torch.parts.contact_options import ContactOptions
from aicon_torch.parts.validation import (
    check_choice,
    check_not_negative,
    check_positive,
    check_steps,
    numbers,
)
from aicon_torch.resolution import NullspaceProjection, Resolution

CONTACT = ContactOptions(size=T_WIDTH)


@dataclass(frozen=True)
class Options:
    """Options of the pushing policy.

    Attributes:
        resolution: What happens where gradients meet.
        law: From the gradients to the action.
        dtype: Precision of the estimates.
        keypoints: Corners of the object in its body frame, in the order of the sensor, m; None for
            the T.
        outline_order: Their order around the object; by default as given.
        center_of_mass: In the body frame, m; by default the polygon's.
        radius_of_gyration: In m; by default the polygon's.
        goal_pose: Target of the body frame (x, y, θ), m and rad.
        observe_goal: Whether the target is observed instead, as ``goal_pose``.
        dt: Time step, s; a multiple of the PD controller's sub-step of 0.01 s.
        max_speed: Largest speed, m/s.
        command: Whether the action is sent as the PD controller's position target or as the
            velocity itself.
        compensate_lag: Whether the position target takes the controller's lag into account.
        picture: File of a trained :class:`aicon_torch.models.pusht.picture.PoseNetwork`, which sees
            the object in ``pixels``; None reads its keypoints instead.
        picture_noise: Standard deviation of where it is seen there, m, always the same; None takes
            what the network tells of each picture.
        push_noise: Standard deviation of what a push does besides the model, as a share of what it
            does; 0 leaves the process noise as large where nothing is pushed.
        keypoint_noise: Standard deviation of each coordinate of a keypoint, m.
        keypoint_offset: Standard deviation of an offset that all keypoints have in common, m; 0 if
            there is none. It is estimated from what touches what.
        estimation: Whether pusher and object are filtered, or read off the sensors.
        delay: Largest age of a reading that is made up for, steps; ages come as ``age``, s, and
            are this one where they do not. Without estimation readings are taken as they come.
        watchdog: Whether the pusher stops on readings that are too old or frozen.
        likelihood_path: Whether p₁ is there, which leads over the likelihood of a contact.
        position_path: Whether p₂ is there, which leads over its position.
        contact: What a contact does and how likely it is.
    """

    resolution: Resolution = field(default_factory=NullspaceProjection)
    law: ActionLaw = field(default_factory=Foresight)
    dtype: torch.dtype = torch.float64
    keypoints: Sequence[Sequence[float]] | None = None
    outline_order: Sequence[int] | None = None
    center_of_mass: Sequence[float] | None = None
    radius_of_gyration: float | None = None
    goal_pose: Sequence[float] = GOAL_POSE
    observe_goal: bool = False
    dt: float = 0.1
    max_speed: float = 800 * PIXEL
    command: Literal["position", "velocity"] = "position"
    compensate_lag: bool = True
    picture: str | Path | None = None
    picture_noise: float | None = None
    push_noise: float = 0.0
    keypoint_noise: float = 0.1 * PIXEL
    keypoint_offset: float = 0.0
    estimation: bool = True
    delay: int = 0
    watchdog: bool = True
    likelihood_path: bool = True
    position_path: bool = True
    contact: ContactOptions = CONTACT

    def __post_init__(self) -> None:
        """Check what the groups do not check themselves.

        Raises:
            OptionError: If an option is not what it may be.
        """
        check_positive(self, ("dt", "max_speed", "keypoint_noise"))
        check_not_negative(self, ("keypoint_offset", "push_noise"))
        check_choice(self, "command", ("position", "velocity"))
        numbers("goal_pose", self.goal_pose, 3)
        check_steps(self, "delay")
        if self.picture_noise is not None:
            check_positive(self, ("picture_noise",))
        if self.picture is not None and (self.keypoint_offset or self.delay):
            raise OptionError(
                "picture: what is seen in pictures is prompt and has no keypoints; expected "
                "keypoint_offset=0 and delay=0."
            )

        # A step is a whole number of sub-steps, over which the controller is one linear map.
        if self.dt < SUBSTEP or abs(self.dt / SUBSTEP - self.substeps) > 1e-6:
            raise OptionError(
                f"dt={self.dt!r}: expected a multiple of {SUBSTEP} s, the PD controller's sub-step."
            )

    @property
    def substeps(self) -> int:
        """Number of the PD controller's sub-steps in a step."""
        return round(self.dt / SUBSTEP)

    @property
    def filtered_delay(self) -> int:
        """For how many steps the filters move on from when a reading was taken: none without."""
        return self.delay if self.estimation else 0
