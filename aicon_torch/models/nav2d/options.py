"""Options of the navigation policy, and its presets."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import torch

from aicon_torch.control import ActionLaw, DirectDescent, Foresight
from aicon_torch.resolution import (
    Exploration,
    NullspaceProjection,
    Resolution,
    SteepestPath,
    Sum,
    TrapEscape,
)
from aicon_torch.validation import (
    check_choice,
    check_count,
    check_flags,
    check_not_negative,
    check_positive,
)

ESCAPE = TrapEscape(progress="reach", hold="avoid", along="avoid")
"""How it leaves a trap: exploration ends only once the target is nearer than when it began, holds
the level of p_collision, and moves in the nullspace of p₃ even where p₁ dominates."""

RESOLUTION = NullspaceProjection(exploration=Exploration(escape=ESCAPE))


@dataclass(frozen=True)
class Options:
    """Options of the navigation policy.

    Attributes:
        resolution: What happens where gradients meet.
        law: From the gradients to the action.
        dtype: Precision of the estimates.
        dt: Time step, s.
        max_speed: Largest speed, m/s.
        sensing: ``"range"``, or ``"range_bearing"`` if the direction of the nearest obstacle is
            measured as well.
        bearing_noise: Standard deviation of bearings, rad.
        range_noise: Standard deviation of the clearance, m.
        actuation_noise: Standard deviation of each velocity component, m/s.
        delay: Largest age of a reading that is made up for, steps; ages come as ``age``, s, and
            are this one where they do not.
        action_delay: How many steps later than usual the next action may take effect; near an
            obstacle there is room for what the agent does until then.
        range_offset: By how much all clearances may be too long, m; there is room for that, too.
        watchdog: Whether the agent stops on readings that are too old or frozen.
    """

    resolution: Resolution = RESOLUTION
    law: ActionLaw = field(default_factory=Foresight)
    dtype: torch.dtype = torch.float64
    dt: float = 0.05
    max_speed: float = 0.5
    sensing: Literal["range", "range_bearing"] = "range"
    bearing_noise: float = 0.03
    range_noise: float = 0.01
    actuation_noise: float = 0.02
    delay: int = 0
    action_delay: int = 0
    range_offset: float = 0.0
    watchdog: bool = True

    def __post_init__(self) -> None:
        """Check what resolution and law do not check themselves.

        Raises:
            OptionError: If an option is not what it may be.
        """
        check_positive(self, ("dt", "max_speed"))
        check_count(self, ("delay", "action_delay"), "number of steps")
        check_not_negative(self, ("range_offset",))
        check_positive(self, ("bearing_noise", "range_noise", "actuation_noise"))
        check_choice(self, "sensing", ("range", "range_bearing"))
        check_flags(self)


PRESETS: Mapping[str, Mapping[str, Any]] = {
    "aicon": {},
    "paper_literal": {
        "resolution": NullspaceProjection.as_in_paper(),
        "law": DirectDescent.as_in_paper(gain=10.0),
    },
    "steepest": {
        "resolution": SteepestPath(),
        "law": DirectDescent.as_in_paper(gain=0.3),
        "max_speed": 0.25,
    },
    "potential_field": {
        "resolution": Sum(),
        "law": DirectDescent.as_in_paper(gain=0.6),
        "max_speed": 0.25,
    },
}
"""Options by dotted name, for each preset: ours, the paper's text and nothing else, the baselines.

Gain, speed and law are the best of the same search for each policy (``scripts/tune.py``).
"""
