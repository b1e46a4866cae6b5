"""Named options of the pushing policy: ours, the baselines, and what is nearer to the text.

- ``slow_approach``: likelihoods of two ranges and any opposing partner, but the sine for the effect
  of a contact, a slow approach instead of limits, and position targets that leave the lag of the
  controller to itself;
- ``slow_approach_ungrouped``: besides, each path a candidate of its own, and the second strongest
  as partner;
- ``paper_literal``: besides, one likelihood for all contacts, the angle for the effect, the softmax
  over magnitudes as they are, and no limits. What is left of ours: the gradient sets the velocity
  where Eq. 2 changes it, λ compares magnitudes, and the motion average takes 0.4 s. Nothing is left
  with ``resolution=NullspaceProjection.as_in_paper()`` and ``law=ActionLaw.as_in_paper(gain)``.

Gain and speed are the best of the same search for each policy (``scripts/tune.py --task pusht``).
"""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from aicon_torch.models.pusht.benchmark import PIXEL
from aicon_torch.parts.contact_options import SlowApproachOptions
from aicon_torch.resolution import SteepestPath, Sum

_SLOW_APPROACH = {
    "contact.effect": "sine",
    "contact.rotation": 65.0 / 3000**0.5,  # L = 65 px for the T
    "contact.reach": 1 / 3,
    "contact.facing": False,
    "contact_limits": SlowApproachOptions(),
    "compensate_lag": False,
    "max_speed": 600 * PIXEL,
    "law.smoothing": 0.025,
}

_UNGROUPED = {
    **_SLOW_APPROACH,
    "resolution.by_row": False,
    "resolution.exploration.partner": "second",
}

_PAPER_LITERAL = {
    **_UNGROUPED,
    "resolution.relative": False,
    "law.smoothing": 0.1,
    "contact.effect": "angle",
    "contact.reach": 1 / 12,
    "contact.aim": 0.0,
    "contact_limits": None,
}

PRESETS: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        "aicon": {},
        "paper_literal": _PAPER_LITERAL,
        "steepest": {"resolution": SteepestPath()},
        "potential_field": {"resolution": Sum()},
        "slow_approach": _SLOW_APPROACH,
        "slow_approach_ungrouped": _UNGROUPED,
        "steepest_without_contact_limits": {"resolution": SteepestPath(), "contact_limits": None},
        "potential_field_without_contact_limits": {"resolution": Sum(), "contact_limits": None},
    }
)
"""Options by dotted name, for each preset."""
