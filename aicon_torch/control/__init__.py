"""Control: one step, from the gradients of the goals to an action."""

from aicon_torch.control.action_law import ActionLaw
from aicon_torch.control.backward import BackwardPass
from aicon_torch.control.direct import DirectDescent
from aicon_torch.control.foresight import Foresight
from aicon_torch.control.plan import PartialPath
from aicon_torch.control.step import ControlStep

__all__ = [
    "ActionLaw",
    "BackwardPass",
    "ControlStep",
    "DirectDescent",
    "Foresight",
    "PartialPath",
]
