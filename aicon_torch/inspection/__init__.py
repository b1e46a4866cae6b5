"""Inspection: what a step knew and decided, for one robot in words and for many in tensors."""

from aicon_torch.inspection.explanation import Explanation
from aicon_torch.inspection.trace import QuantityTrace, StepTrace

__all__ = ["Explanation", "QuantityTrace", "StepTrace"]
