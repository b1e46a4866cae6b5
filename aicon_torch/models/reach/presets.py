"""Presets of reaching: ours and the baselines, as options that differ from the defaults."""

from collections.abc import Mapping
from typing import Any

from aicon_torch.dampers import PlaceEscape
from aicon_torch.parts.hinge import SquaredHinge
from aicon_torch.resolution import SteepestPath, Sum

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
        "dampers.sweeps": 150,
        "dampers.haste": 1.0,
        "dampers.escape": PlaceEscape(whole=(1, 3)),
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
