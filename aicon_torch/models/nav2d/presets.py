"""Named options of the navigation policy: ours, the paper's text and nothing else, the baselines.

Gain, speed and law are the best of the same search for each policy (``scripts/tune.py``).
"""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from aicon_torch.control import DirectDescent
from aicon_torch.resolution import NullspaceProjection, SteepestPath, Sum

PRESETS: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
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
)
"""Options by dotted name, for each preset."""
