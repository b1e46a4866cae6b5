"""The axes along which joints, tips and handles go, or about which they turn: unit vectors."""

import math
from typing import Any

from aicon_torch.errors import OptionError
from aicon_torch.validation import numbers

ROUNDING = 1e-6
"""By how much the length of an axis may differ from one."""


def check_axis(name: str, axis: Any) -> None:
    """Check that an option is a unit vector in space.

    Args:
        name: What an error calls it.
        axis: What was given.

    Raises:
        OptionError: If it is none.
    """
    if not math.isclose(math.hypot(*numbers(name, axis, 3)), 1.0, abs_tol=ROUNDING):
        raise OptionError(f"{name}={axis!r}: expected a unit vector.")
