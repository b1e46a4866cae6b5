"""A robot of LeRobot behind a shield."""

from typing import Any

import numpy as np
from lerobot.robots import Robot, make_robot_from_config
from numpy.typing import NDArray

from aicon_envs.reach.robots import ROBOTS, find_file
from aicon_torch import Shield
from aicon_torch.inspection.shielding import Shielding
from aicon_torch.models.reach import Options, body_model, towards
from aicon_torch.parts import Robot as Arm
from aicon_torch.shield import ShieldState
from lerobot_robot_aicon.config_aicon_shield import AiconShieldConfig

WANTED = "wanted"
"""The observation's key of where the joints are sent, rad."""


class AiconShield(Robot):
    """Sends a robot where it is told to go, as far as its stops, a table and its own links allow.

    It is the robot within in everything but `send_action`, whose result is what was really sent.
    Joints that the description does not have, such as a gripper's, go as they are told.

    Where the arm goes is computed for the joints *as they were commanded last*, which servos follow
    with a lag; they run ahead of the true ones by the configured lead at most, so that an arm that
    is held, or pushed, is not left behind.

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

        arm = _arm(config)
        self._keys = [f"{config.motors.get(joint, joint)}.pos" for joint in arm.chain.names]
        missing = [key for key in self._keys if key not in self.inner.action_features]
        if missing:
            raise ValueError(
                f"The robot has no {', '.join(missing)}: it has "
                f"{', '.join(self.inner.action_features)}. Say which motor turns which joint of "
                "the description: --robot.motors='{joint: motor}'"
            )
        self._offsets = np.array([config.offsets.get(joint, 0.0) for joint in arm.chain.names])

        options = Options(robot=arm, speed=config.speed, dt=1.0 / config.fps)
        model = body_model(options, config.table)
        shield = Shield(_wanted, model, nominal=towards, goes_around=config.goes_around)
        self._shield = shield.compile()
        self._forget()

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
        self._forget()

    def calibrate(self) -> None:
        """Calibrate the robot within."""
        self.inner.calibrate()

    def configure(self) -> None:
        """Configure the robot within."""
        self.inner.configure()

    def disconnect(self) -> None:
        """Disconnect the robot within."""
        self.inner.disconnect()

    def get_observation(self) -> dict[str, Any]:
        """What the robot within observes."""
        observation: dict[str, Any] = self.inner.get_observation()
        self._measured = self._joints(observation)
        return observation

    def send_action(self, action: dict[str, Any]) -> dict[str, Any]:
        """Send the nearest action that is allowed.

        Args:
            action: Where each motor shall go.

        Returns:
            What was sent.
        """
        if self._measured is None:
            self.get_observation()
        assert self._measured is not None
        lead = np.radians(self.config.lead)
        commanded = self._measured if self._commanded is None else self._commanded
        commanded = np.clip(commanded, self._measured - lead, self._measured + lead)

        observation = {"q": commanded, WANTED: self._joints({**self._degrees(commanded), **action})}
        velocity, self._state = self._shield.predict(observation, self._state)
        self._commanded = commanded + np.asarray(velocity) / self.config.fps
        sent: dict[str, Any] = self.inner.send_action({**action, **self._degrees(self._commanded)})
        return sent

    def explain(self) -> Shielding | None:
        """What was changed in the last action, and why; None before the first."""
        return None if self._state is None else self._shield.explain(self._state)

    def _forget(self) -> None:
        """Begin anew."""
        self._state: ShieldState | None = None
        self._measured: NDArray[Any] | None = None
        self._commanded: NDArray[Any] | None = None

    def _joints(self, positions: dict[str, Any]) -> NDArray[Any]:
        """The joints of the description, ``(n,)``, rad."""
        degrees = np.array([float(positions[key]) for key in self._keys])
        return np.radians(degrees - self._offsets)

    def _degrees(self, joints: NDArray[Any]) -> dict[str, float]:
        """What the motors call them, degrees."""
        degrees = np.degrees(joints) + self._offsets
        return dict(zip(self._keys, degrees.tolist(), strict=True))


def _arm(config: AiconShieldConfig) -> Arm:
    """The arm that is described."""
    known = ROBOTS.get(config.urdf)
    if known is None:
        return Arm.from_urdf(config.urdf, tip=config.tip, srdf=config.srdf)
    srdf = None if known.srdf is None else find_file(known.srdf)
    return Arm.from_urdf(find_file(known.urdf), tip=known.tip, srdf=srdf)


def _wanted(observation: dict[str, Any]) -> Any:
    """Where the joints are sent, rad."""
    return observation[WANTED]
