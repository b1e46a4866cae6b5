"""The joints of an arm as its encoders read them, filtered."""

from collections.abc import Sequence

from aicon_torch.estimation import EKF, Measurement, ekf_with_delay
from aicon_torch.interconnections import Affine

JOINT_NOISE = 1e-4
"""Standard deviation of an encoder, rad."""

JOINT_DRIFT = 1e-6
"""Variance of what moves a joint in a step besides its command, rad²."""

UNKNOWN_JOINT = 10.0
"""Variance of a joint before it is read, rad²."""


def joint_filter(middle: Sequence[float], moved_by: str = "a", delay: int = 0) -> EKF:
    """x_joints, from the readings z_joints ``(*B, n)``, rad or m.

    Args:
        middle: Where the n joints are believed before they are read, give or take much, rad or m.
        moved_by: The quantity that is their velocity, rad/s or m/s.
        delay: Largest age of a reading that is made up for, steps.
    """
    agreement = Affine(x_joints=1.0, z_joints=-1.0)
    return ekf_with_delay(
        "x_joints",
        "P_joints",
        delay=delay,
        sensor="z_joints",
        moved_by={moved_by: len(middle), "dt": 1},
        predict=Affine(x_joints=1.0, **{moved_by: "dt"}),
        noise=JOINT_DRIFT,
        initial=(middle, UNKNOWN_JOINT),
        correct=[Measurement(agreement, JOINT_NOISE**2, size=len(middle))],
    )
