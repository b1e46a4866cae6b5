"""Safety: what an actuator keeps whatever its goals ask, and what it does where that stops it."""

from aicon_torch.safety.quadratic_programme import nearest_safe
from aicon_torch.safety.rows import SafeAction, SafetyBounds

__all__ = ["SafeAction", "SafetyBounds", "nearest_safe"]
