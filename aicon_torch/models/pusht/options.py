"""Options of the pushing policy, in SI units, and its presets."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import torch

from aicon_torch.control import ActionLaw, DirectDescent, Foresight
from aicon_torch.errors import OptionError
from aicon_torch.models.pusht.benchmark import GOAL_POSE, PIXEL, SUBSTEP, T_WIDTH
from aicon_torch.parts.contact_options import ContactOptions
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
        check_count(self, ("delay",), "number of steps")
        check_instance(self, ("contact",), ContactOptions, "ContactOptions(size=0.1)")
        check_flags(self)
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


_PAPER_LITERAL = {
    "resolution": NullspaceProjection.as_in_paper(),
    "law": DirectDescent(),
    "contact.effect": "angle",
    "contact.rotation": 65.0 / 3000**0.5,  # L = 65 px for the T
    "contact.reach": 1 / 12,
    "contact.step": 1 / 12,
    "contact.aim": 0.0,
    "contact.facing": False,
}

PRESETS: Mapping[str, Mapping[str, Any]] = {
    "aicon": {},
    "paper_literal": _PAPER_LITERAL,
    "steepest": {"resolution": SteepestPath(), "law.step": 2 / 3},
    "potential_field": {"resolution": Sum(), "law.step": 4 / 3},
}
"""Options by dotted name, for each preset: ours, the baselines, and what is nearer to the text.

``paper_literal`` is the text: its rule, one likelihood for all contacts, the angle for the effect
of one, and Eq. 2 at the current estimates, but as a velocity. Its softmax compares magnitudes as
they are, so that their scale counts, which the text leaves open: an object that is touched goes as
far as the pusher, so a contact that is certain moves it by the range of the likelihood.

The first step of the baselines' foresight is the best of a search (``scripts/tune.py``).
"""
