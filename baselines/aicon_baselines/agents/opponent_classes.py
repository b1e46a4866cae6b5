"""Opponents: what others would do in a task, to compare AICON with.

Each is a class, whose fields are its options and which needs none of them.
"""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from aicon_baselines.agents.nav2d import Bug2, WallFollower
from aicon_baselines.agents.reach import DampedLeastSquares, Mink
from aicon_baselines.resolutions import Aggregation, CAGrad, PCGrad, UPGrad

AGGREGATIONS: Mapping[str, type[Aggregation]] = MappingProxyType(
    {"pcgrad": PCGrad, "upgrad": UPGrad, "cagrad": CAGrad}
)
"""Rules for gradients in conflict: in every task, in place of ours and with all else as it is."""

AGENTS: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        "nav2d": {"bug2": Bug2, "wall_follower": WallFollower},
        "pusht": {},
        "arm_push": {},
        "reach": {"damped_least_squares": DampedLeastSquares, "mink": Mink},
    }
)
"""Agents that share nothing with AICON but the task, by task."""
