"""Control: from an observation to an action."""

from aicon_torch.control.action_law import ActionLaw
from aicon_torch.control.backward import BackwardPass
from aicon_torch.control.explanation import Explanation, explain
from aicon_torch.control.policy import ACTIVE, Policy

__all__ = ["ACTIVE", "ActionLaw", "BackwardPass", "Explanation", "Policy", "explain"]
