"""Named options of the pushing policy: ours, the baselines, and what is nearer to the text.

``paper_literal`` is the text: its rule, one likelihood for all contacts, the angle for the effect
of one, and Eq. 2 at the current estimates, but as a velocity. Its softmax compares magnitudes as
they are, so that their scale counts, which the text leaves open: an object that is touched goes as
far as the pusher, so a contact that is certain moves it by the range of the likelihood.

The first step of the baselines' foresight is the best of a search (``scripts/tune.py``).
"""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from aicon_torch.control import DirectDescent
from aicon_torch.resolution import NullspaceProjection, SteepestPath, Sum

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

PRESETS: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        "aicon": {},
        "paper_literal": _PAPER_LITERAL,
        "steepest": {"resolution": SteepestPath(), "law.step": 2 / 3},
        "potential_field": {"resolution": Sum(), "law.step": 4 / 3},
    }
)
"""Options by dotted name, for each preset."""
