"""The arm's presets: ours and the baselines, as options that differ from the defaults."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from aicon_torch.control import Foresight
from aicon_torch.resolution import SteepestPath, Sum

REACTION = 0.1
"""Time constant with which the joints' velocities follow their commands, s."""

FORESIGHT: Mapping[str, Any] = MappingProxyType(
    {
        "law": Foresight(horizon=REACTION, dither=0.0),
        "contact_limits": None,
        "contact.inset": 1.0,
        "stick_friction": 0.2,
        "ring": (0.45, 0.652),
        "limits.tip_speed": 0.3,
        "limits.joint_speed": 2.4,
    }
)
"""Foresight over the reaction of the joints in place of limits near contact.

The ring is as wide as the tip reaches, less the farthest corner of the T and the stick: 0.30 and
0.801 m, less 0.15 m at either edge.
"""

PRESETS: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        "aicon": {},
        "foresight": FORESIGHT,
        "steepest": {"resolution": SteepestPath()},
        "potential_field": {"resolution": Sum()},
    }
)
"""Options by preset: ours, foresight, the steepest path (Eq. 2), and plain backpropagation."""
