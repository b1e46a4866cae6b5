"""Safety: what an actuator keeps whatever its goals wish, and how it comes free again."""

from aicon_torch.safety.dampers import ConstraintEscape, VelocityDampers
from aicon_torch.safety.projection import GapRows, SafeAction, nearest_safe

__all__ = ["ConstraintEscape", "GapRows", "SafeAction", "VelocityDampers", "nearest_safe"]
