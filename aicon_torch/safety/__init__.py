"""Safety: what an actuator keeps whatever its goals wish, and how it comes free again."""

from aicon_torch.safety.dampers import ConstraintEscape, VelocityDampers
from aicon_torch.safety.projection import SafeAction, SafetyBounds, nearest_safe

__all__ = ["ConstraintEscape", "SafeAction", "SafetyBounds", "VelocityDampers", "nearest_safe"]
