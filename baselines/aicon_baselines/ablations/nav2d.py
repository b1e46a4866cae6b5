"""Ablations of the navigation policy."""

from collections.abc import Mapping
from typing import Any

from aicon_baselines.ablations.mechanism import ONE_GRADIENT, PLAIN_SUM, WEIGHTED_SUM

ABLATIONS: Mapping[str, Mapping[str, Any]] = {
    "one_gradient": ONE_GRADIENT,
    # The escape from traps: what ends exploration, at which level it moves, and along what.
    "without_progress_exit": {"resolution.exploration.escape.progress": None},
    "without_level_hold": {"resolution.exploration.escape.hold": None},
    "without_obstacle_nullspace": {"resolution.exploration.escape.along": None},
    # The resolution of conflicts.
    "weighted_sum": WEIGHTED_SUM,
    "sum_with_exploration": PLAIN_SUM,
    "without_exploration": {"resolution.exploration": None},
    "without_softmax": {"resolution.temperature": None},
    "without_hysteresis": {"resolution.margin": 0.0},
    "mechanism_as_in_paper": {
        "resolution.relative": False,
        "resolution.exploration.opponent": "second",
        "resolution.exploration.ratio_of": "weights",
        "resolution.exploration.average_time": 1.0,
    },
}
"""Options by name, on top of the preset ``"aicon"``."""
