"""The clock of a control loop that does not keep its period."""

from aicon_torch.quantities import Sensor

LONGEST = 10.0
"""The longest step that is believed, in time steps."""


def clock(dt: float) -> Sensor:
    """How long the last step took, ``elapsed`` ``(*B, 1)``, s, for ``WorldModel(clock=)``.

    An observation need not tell it: then the step took as long as it should, as it does where the
    clock says that it took longer than ten times that.

    Args:
        dt: How long a step should take, s.

    Example:
        >>> WorldModel(
        ...     sensors={"z": Sensor(2, "m"), "z_elapsed": clock(0.05)}, clock="z_elapsed", dt=0.05,
        ...     ...
        ... )
    """
    return Sensor(1, "s", key="elapsed", optional=True, range=(0.0, LONGEST * dt))
