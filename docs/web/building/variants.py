"""The policies of a task that a page switches between: the rule, exploration and foresight."""

from collections.abc import Iterator, Mapping
from types import ModuleType
from typing import Any

from aicon_baselines.ablations import PLAIN_SUM
from aicon_torch import DirectDescent, Policy, SteepestPath, Sum, make_policy

NO_EXPLORATION = {"resolution.exploration": None}
ONE_GRADIENT = {"law": DirectDescent()}

RULES: Mapping[str, Mapping[str, Any]] = {
    "projection+explore": {},
    "projection": NO_EXPLORATION,
    "sum+explore": PLAIN_SUM,
    "sum": {"resolution": Sum()},
    "steepest": {"resolution": SteepestPath()},
}
"""What happens where gradients meet, as options on top of what is shipped.

The steepest path never explores: it compares complete paths, where nothing meets.
"""

LAWS: Mapping[str, Mapping[str, Any]] = {"+foresight": {}, "": ONE_GRADIENT}
"""What makes an action of a gradient: nothing else is changed, so no gain is tuned to a rule."""


def variants(model: str | ModuleType, **options: Any) -> Iterator[tuple[str, Policy]]:
    """The policies of a model by name, such as ``"projection+explore+foresight"``."""
    for rule, resolution in RULES.items():
        for law, action_law in LAWS.items():
            policy = make_policy(model, **{**options, **resolution, **action_law})
            yield rule + law, policy
