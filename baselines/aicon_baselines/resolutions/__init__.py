"""Rules of multi-task learning for gradients in conflict, as resolutions to compare ours with.

| file | content |
|---|---|
| `aggregation.py` | what they have in common: one matrix at a time, and what they need |
| `torchjd.py` | PCGrad and UPGrad, computed by TorchJD |
| `cagrad.py` | CAGrad, its cone program solved by Clarabel |
"""

from aicon_baselines.resolutions.aggregation import Aggregation
from aicon_baselines.resolutions.cagrad import CAGrad
from aicon_baselines.resolutions.torchjd import PCGrad, UPGrad

__all__ = ["Aggregation", "CAGrad", "PCGrad", "UPGrad"]
