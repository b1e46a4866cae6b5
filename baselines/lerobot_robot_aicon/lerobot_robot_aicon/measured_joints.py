"""Where the joints of an arm are, as far as its motors' readings can be true."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from aicon_torch.parts.chain import Chain
from aicon_torch.readings.sensor_validation import PATIENCE
from lerobot_robot_aicon.arm_options import ArmOptions
from lerobot_robot_aicon.motors import TURN

BEYOND_STOP = math.radians(10.0)
"""A reading farther beyond a joint's stops, rad, is none; by less, a calibration may err."""

NOISE, PUSH = math.radians(2.0), 3.0
"""A joint is where it was, where it is sent, or on the way; besides, it may be pushed by so much
in a step: the error of a motor, rad, and the speed of a push, rad/s."""

REMEDY = (
    "is not moved. Either it is to be moved there by hand, or the description does not "
    "stand as the arm does: see --robot.offsets, --robot.signs and its calibration."
)


class Believed(NamedTuple):
    """What the readings of a step are worth.

    Attributes:
        joints: The last reading of each joint that was believed ``(n,)``, rad.
        is_believed: Whether that is the reading of this step ``(n,)``.
        has_jumped: Whether it is believed only because the last ones agree ``(n,)``.
    """

    joints: NDArray[np.float64]
    is_believed: NDArray[np.bool_]
    has_jumped: NDArray[np.bool_]


class MeasuredJoints:
    """Tells the readings of motors that can be true from those that cannot, joint by joint.

    =====================================================  ========
    reading                                                believed
    =====================================================  ========
    the first of an episode                                no
    of the next ones the first that agrees with the last   yes
    not finite, or beyond the stops                        no
    near where the joint was or is sent, or between        yes
    elsewhere, the fourth in a row that agree              yes
    elsewhere, otherwise                                   no
    =====================================================  ========

    Within the stops and near allow for some error: see ``BEYOND_STOP``, ``NOISE`` and ``PUSH``.

    Args:
        chain: The description's joints.
        options: Their speed, and how many actions there are in a second.
    """

    def __init__(self, chain: Chain, options: ArmOptions) -> None:
        self._names = chain.names
        self._low, self._high = chain.low.numpy(), chain.high.numpy()
        self._near = NOISE + PUSH / options.fps
        self._agreeing = self._near + options.speed / options.fps
        width = self._high - self._low + 2 * BEYOND_STOP
        self._may_wrap = chain.turns.squeeze(-1).numpy() & (width >= TURN)
        self.reset()

    def reset(self) -> None:
        """Forget what was read."""
        self._last = self._believed = np.full(len(self._names), np.nan)
        self._agreed = np.zeros(len(self._names), np.int64)

    def begin(self, reading: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Take a reading of an arm that has not been moved ``(n,)``, rad.

        Returns:
            Whether it agrees with the one before ``(n,)``. An episode begins where all do: one
            reading may be wrong.

        Raises:
            ValueError: If a joint has none, or one that is beyond its stops.
        """
        possible = self._is_possible(reading)
        for name, q, low, high, can_be in zip(
            self._names, reading, self._low, self._high, possible, strict=True
        ):
            if not math.isfinite(q):
                raise ValueError(
                    f"{name}: its motor shows {q}, and an episode begins where the arm stands, "
                    "so the arm is not moved. Expected a finite number."
                )
            if not can_be:
                found, least, most = np.degrees([q, low, high])
                raise ValueError(
                    f"{name} seems to stand at {found:.0f}°, beyond its stops, "
                    f"{least:.0f}° and {most:.0f}°, so the arm {REMEDY}"
                )

        agrees = np.abs(reading - self._last) <= self._near
        self._last = self._believed = reading
        return agrees

    def __call__(self, reading: NDArray[np.float64], commanded: NDArray[np.float64]) -> Believed:
        """What the next reading is worth.

        Args:
            reading: What the motors show ``(n,)``, rad.
            commanded: Where the joints were sent ``(n,)``, rad.
        """
        is_possible = self._is_possible(reading)
        is_near = self._is_near(reading, commanded)

        # Does it agree with those just before it, wherever they are?
        agrees = is_possible & (np.abs(reading - self._last) <= self._agreeing)
        self._agreed = np.where(agrees, self._agreed + 1, 0)
        self._last = np.where(is_possible, reading, self._last)

        has_jumped = ~is_near & (self._agreed >= PATIENCE - 1)
        is_believed = is_near | has_jumped
        self._believed = np.where(is_believed, reading, self._believed)
        return Believed(self._believed, is_believed, has_jumped)

    def turns(
        self, reading: NDArray[np.float64], commanded: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """How many turns the next reading is away from where the joints can be ``(n,)``.

        A motor that counts within one turn shows -179° for 181°. It is 0 for a joint that cannot
        stand a turn farther, and for a reading that is elsewhere in any case.

        Args:
            reading: What the motors show ``(n,)``, rad.
            commanded: Where the joints were sent ``(n,)``, rad.
        """
        turns = np.where(self._may_wrap, np.round((reading - self._believed) / TURN), 0.0)
        is_near = self._is_near(reading - TURN * turns, commanded)
        return np.where(is_near, turns, 0.0)

    def _is_near(
        self, reading: NDArray[np.float64], commanded: NDArray[np.float64]
    ) -> NDArray[np.bool_]:
        """Whether each joint can have come there since its last reading that was believed."""
        least = np.minimum(self._believed, commanded) - self._near
        most = np.maximum(self._believed, commanded) + self._near
        return self._is_possible(reading) & (least <= reading) & (reading <= most)

    def _is_possible(self, reading: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Whether each joint can stand where its motor shows, ``(n,)``; NaN cannot."""
        least, most = self._low - BEYOND_STOP, self._high + BEYOND_STOP
        return np.isfinite(reading) & (least <= reading) & (reading <= most)
