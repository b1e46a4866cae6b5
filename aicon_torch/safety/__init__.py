"""Safety: what an actuator keeps whatever its goals ask for, and how it comes free again."""

from aicon_torch.safety.quadratic_programme import SafeAction, SafetyBounds, nearest_safe

__all__ = ["SafeAction", "SafetyBounds", "nearest_safe"]
