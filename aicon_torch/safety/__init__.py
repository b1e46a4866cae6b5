"""Safety: what an actuator keeps whatever its goals ask, and what it does where that stops it."""

from aicon_torch.safety.quadratic_programme import SafeAction, SafetyBounds, nearest_safe

__all__ = ["SafeAction", "SafetyBounds", "nearest_safe"]
