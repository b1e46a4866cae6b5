"""Control: from an observation to an action, and what was decided on the way."""

from aicon_torch.control.action_law import ActionLaw
from aicon_torch.control.background import BackgroundPerception
from aicon_torch.control.backward import BackwardPass, PartialPath
from aicon_torch.control.direct import DirectDescent
from aicon_torch.control.explanation import Explanation
from aicon_torch.control.exported import ExportedPolicy, load_exported
from aicon_torch.control.foresight import Foresight
from aicon_torch.control.perception import Perception, SlowPerception
from aicon_torch.control.policy import Policy
from aicon_torch.control.step import ControlStep
from aicon_torch.control.trace import QuantityTrace, StepTrace

__all__ = [
    "ActionLaw",
    "BackgroundPerception",
    "BackwardPass",
    "ControlStep",
    "DirectDescent",
    "Explanation",
    "ExportedPolicy",
    "Foresight",
    "PartialPath",
    "Perception",
    "Policy",
    "QuantityTrace",
    "SlowPerception",
    "StepTrace",
    "load_exported",
]
