"""A robot of LeRobot behind a shield."""

from typing import Any

from lerobot.robots import Robot, make_robot_from_config

from aicon_torch.inspection.shielding import Shielding
from lerobot_robot_aicon.config_aicon_shield import AiconShieldConfig
from lerobot_robot_aicon.interference import Interference
from lerobot_robot_aicon.joint_shield import JointShield
from lerobot_robot_aicon.motors import check_mapping


class AiconShield(Robot):
    """Sends a robot where it is told to go, as far as its bounds allow: see :class:`JointShield`.

    It is the robot within in everything but `send_action`, whose result is what was really sent.

    Args:
        config: The robot and its bounds.

    Raises:
        ValueError: If the robot counts in other units than degrees, or lacks a motor for a joint.
    """

    config_class = AiconShieldConfig
    name = "aicon_shield"

    def __init__(self, config: AiconShieldConfig) -> None:
        self.inner: Robot = make_robot_from_config(config.inner)
        super().__init__(config)
        self.config = config
        if not getattr(config.inner, "use_degrees", True):
            raise ValueError(
                "robot.inner.use_degrees is false: a shield needs angles, expected "
                "--robot.inner.use_degrees=true"
            )

        self._shield = JointShield(config)
        missing = [key for key in self._shield.joints.keys if key not in self.action_features]
        if missing:
            raise ValueError(
                f"The robot has no {', '.join(missing)}: it has "
                f"{', '.join(self.action_features)}. Say which motor turns which joint of "
                "the description: --robot.motors='{joint: motor}'"
            )
        self._shield.warm_up()
        self._interference = Interference(self._shield)
        self._measured: dict[str, Any] | None = None
        self._was_calibrated = False

    @property
    def observation_features(self) -> dict[str, Any]:
        """Those of the robot within."""
        features: dict[str, Any] = self.inner.observation_features
        return features

    @property
    def action_features(self) -> dict[str, Any]:
        """Those of the robot within."""
        features: dict[str, Any] = self.inner.action_features
        return features

    @property
    def is_connected(self) -> bool:
        """Whether the robot within is connected."""
        return bool(self.inner.is_connected)

    @property
    def is_calibrated(self) -> bool:
        """Whether the robot within is calibrated."""
        return bool(self.inner.is_calibrated)

    @property
    def cameras(self) -> Any:
        """Those of the robot within."""
        return getattr(self.inner, "cameras", {})

    def connect(self, calibrate: bool = True) -> None:
        """Connect the robot within."""
        self.inner.connect(calibrate)
        self._measured, self._was_calibrated = None, False
        self._shield.reset()
        self._interference.reset()

    def calibrate(self) -> None:
        """Calibrate the robot within."""
        self.inner.calibrate()

    def configure(self) -> None:
        """Configure the robot within."""
        self.inner.configure()

    def disconnect(self) -> None:
        """Disconnect the robot within."""
        self._interference.close()
        self.inner.disconnect()

    def get_observation(self) -> dict[str, Any]:
        """What the robot within observes."""
        observation: dict[str, Any] = self.inner.get_observation()
        self._measured = observation
        return observation

    def send_action(self, action: dict[str, Any]) -> dict[str, Any]:
        """Send the nearest action that is allowed.

        Args:
            action: Where each motor shall go; those that are left out stay where they are.

        Returns:
            What was sent; nothing before two readings agree on where the robot stands.

        Raises:
            ValueError: If it names a motor that the robot does not have, or has no number for one,
                or the robot at the beginning is not calibrated, or does not stand as described.
        """
        check_mapping("action", action, list(self.action_features))
        unknown = [key for key in action if key not in self.action_features]
        if unknown:
            raise ValueError(
                f"action: the robot has no {', '.join(unknown)}; it has "
                f"{', '.join(self.action_features)}."
            )

        self._check_calibrated()

        # The nearest action that is allowed, from where the robot stands.
        measured = self.get_observation() if self._measured is None else self._measured
        self._measured = None  # once it has moved, it stands elsewhere
        allowed = self._shield(measured, action)
        self._interference.note()

        # Before two readings agree there is none.
        if not allowed.keys() >= set(self._shield.joints.keys):
            return {}
        sent: dict[str, Any] = self.inner.send_action(allowed)
        return sent

    def _check_calibrated(self) -> None:
        """Refuse to move a robot whose motors count from elsewhere; asked once after connecting."""
        is_calibrated = self._was_calibrated or self.inner.is_calibrated
        if is_calibrated is not None and not is_calibrated:  # None: there is nothing to calibrate
            raise ValueError(
                f"{self.inner} is not calibrated as its file says, so where it stands is not known "
                "and it is not moved: connect(calibrate=True), or lerobot-calibrate with its id."
            )
        self._was_calibrated = True

    def explain(self) -> Shielding | None:
        """What was changed in the last action, and why; None before the first, and while held."""
        return self._shield.explain()
