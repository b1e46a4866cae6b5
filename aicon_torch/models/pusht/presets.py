"""Named options of the pushing policy: ours, the baselines, and what is nearer to the text.

``paper_literal`` has each path as a candidate of its own and the second strongest as partner, the
softmax over magnitudes as they are, one likelihood for all contacts, the angle for the effect of
one, and Eq. 2 at the current estimates, as a velocity.

The first step of the baselines' foresight is the best of a search (``scripts/tune.py``).
"""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from aicon_torch.control import DirectDescent
from aicon_torch.resolution import SteepestPath, Sum

_PAPER_LITERAL = {
    "resolution.by_row": False,
    "resolution.exploration.partner": "second",
    "resolution.relative": False,
    "law": DirectDescent(),
    "contact.effect": "angle",
    "contact.rotation": 65.0 / 3000**0.5,  # L = 65 px for the T
    "contact.reach": 1 / 12,
    "contact.aim": 0.0,
    "contact.facing": False,
}

PRESETS: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        "aicon": {},
        "paper_literal": _PAPER_LITERAL,
        "steepest": {"resolution": SteepestPath(), "law.step": 2 / 3},
        "potential_field": {"resolution": Sum(), "law.step": 4 / 3},
    }
)
"""Options by dotted name, for each preset."""
