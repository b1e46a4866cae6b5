"""A simulated arm as a robot of LeRobot."""

from typing import Any

import numpy as np
from lerobot.robots import Robot

from aicon_envs.reach import ReachEnv
from aicon_envs.reach.simulation import CONTROL_STEP
from lerobot_robot_aicon.config_aicon_simulated import AiconSimulatedConfig

SERVO = 0.1
"""The servos go to where they are sent in so long, s."""


class AiconSimulated(Robot):
    """An arm of `aicon_envs.reach`: its joints go where they are sent, as servos do.

    Attributes:
        info: What the physics say after the last action: see :class:`aicon_envs.reach.ReachEnv`.
    """

    config_class = AiconSimulatedConfig
    name = "aicon_simulated"

    def __init__(self, config: AiconSimulatedConfig) -> None:
        super().__init__(config)
        self.config = config
        self._env = ReachEnv(config.robot, "axis", "random", speed=10.0)
        self._keys = [f"{joint}.pos" for joint in self._env.description()["joints"]]
        self._is_connected = False
        self.info: dict[str, Any] = {}

    @property
    def observation_features(self) -> dict[str, Any]:
        """The angle of each joint, degrees."""
        return dict.fromkeys(self._keys, float)

    @property
    def action_features(self) -> dict[str, Any]:
        """Where each joint shall go, degrees."""
        return dict.fromkeys(self._keys, float)

    @property
    def is_connected(self) -> bool:
        """Whether an episode has begun."""
        return self._is_connected

    @property
    def is_calibrated(self) -> bool:
        """There is nothing to calibrate."""
        return True

    def connect(self, calibrate: bool = True) -> None:
        """Begin an episode."""
        observation, self.info = self._env.reset(seed=self.config.seed)
        self._joints, self._is_connected = observation["q"], True

    def calibrate(self) -> None:
        """Nothing."""

    def configure(self) -> None:
        """Nothing."""

    def disconnect(self) -> None:
        """End the episode."""
        self._is_connected = False

    def get_observation(self) -> dict[str, Any]:
        """The angles of the joints, degrees."""
        return dict(zip(self._keys, np.degrees(self._joints).tolist(), strict=True))

    def send_action(self, action: dict[str, Any]) -> dict[str, Any]:
        """Let the servos go there for one step of LeRobot's loop."""
        target = np.radians([float(action[key]) for key in self._keys])
        for _ in range(max(1, round(1 / self.config.fps / CONTROL_STEP))):
            observation, *_, self.info = self._env.step((target - self._joints) / SERVO)
            self._joints = observation["q"]
        return dict(action)
