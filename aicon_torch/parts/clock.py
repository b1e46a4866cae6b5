"""The clock of a control loop that does not keep its period."""

from aicon_torch.quantities import Sensor


def clock() -> Sensor:
    """How long the last step took, ``elapsed`` ``(*B, 1)``, s, for ``WorldModel(clock=)``.

    An observation need not tell it: then the step took as long as it should, as it does where the
    clock says what cannot be (NaN, infinity, a negative number). Where it took more than ten times
    as long, the loop has stalled. What the robot did meanwhile is not known, so nothing is
    predicted; but readings are older by all of that time, and where they are too old the robot
    stands.

    Example:
        >>> WorldModel(
        ...     sensors={"z": Sensor(2, "m"), "z_elapsed": clock()}, clock="z_elapsed", dt=0.05,
        ...     ...
        ... )
    """
    return Sensor(1, "s", key="elapsed", optional=True)
