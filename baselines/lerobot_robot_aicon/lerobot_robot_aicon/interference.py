"""What a shield did, as lines of a log."""

import logging
import time

from lerobot_robot_aicon.joint_shield import JointShield

EVERY = 2.0
"""A line is written so often at most, s."""

_log = logging.getLogger(__name__)


class Interference:
    """Logs what was changed, and why: a line every two seconds at most, and one at the end.

    Args:
        shield: The shield.
    """

    def __init__(self, shield: JointShield) -> None:
        self._shield = shield
        self.reset()

    def reset(self) -> None:
        """Begin anew."""
        self._steps = self._changed = 0
        self._last = -EVERY

    def note(self) -> None:
        """Take the last action into account."""
        self._steps += 1
        if not self._shield.is_changed():
            return

        self._changed += 1
        explained = self._shield.explain()
        if explained is not None and time.monotonic() - self._last >= EVERY:
            self._last = time.monotonic()
            _log.info("Shield, in rad/s: %s", explained)

    def close(self) -> None:
        """Say how often it was changed in all."""
        if self._steps:
            share = 100 * self._changed / self._steps
            _log.info(
                "Shield: %d of %d actions were changed (%.0f %%).",
                self._changed,
                self._steps,
                share,
            )
