"""Building the planner by name, as a comparison does."""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any

from aicon_baselines.agents.mppi.agent import Agent
from aicon_baselines.agents.mppi.options import PRESETS, Options
from aicon_baselines.tasks.registry import load
from aicon_torch.errors import OptionError
from aicon_torch.models import pusht


@dataclass(frozen=True)
class Planner:
    """Builds a planner for a condition of pushT.

    Attributes:
        preset: Name of its options.
        changes: Other values of some of them.
    """

    preset: str
    changes: Mapping[str, Any] = field(default_factory=dict)

    def __call__(self, condition: str) -> Agent:
        """Build it, with what the task tells a policy about the condition.

        Raises:
            OptionError: If there is no such option, or it cannot have this value.
        """
        valid = [option.name for option in fields(Options)]
        unknown = sorted(set(self.changes) - set(valid))
        if unknown:
            raise OptionError(f"unknown option {unknown[0]!r}; MPPI has: {', '.join(valid)}")

        known = load("pusht").policy_options(condition)
        return Agent(replace(PRESETS[self.preset], **self.changes), pusht.Options(**known))
