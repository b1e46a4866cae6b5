"""A simulated arm as a robot of LeRobot."""

from typing import Any

import numpy as np
from lerobot.robots import Robot
from lerobot.utils.errors import DeviceNotConnectedError

from aicon_envs.reach import ReachEnv
from aicon_envs.reach.simulation import CONTROL_STEP
from aicon_torch.validation import check_positive
from lerobot_robot_aicon.config_aicon_simulated import AiconSimulatedConfig
from lerobot_robot_aicon.motors import check_mapping, finite

SERVO = 0.1
"""The servos go to where they are sent in so long, s."""

GRIPPER = "gripper.pos"
"""How far the gripper is open, 0 to 100."""

PICTURE = (480, 360)
"""Width and height of a film, and of a camera that does not say, px."""

FILMED = 3
"""One of so many actions is in the film: pictures take time."""


class AiconSimulated(Robot):
    """An arm of `aicon_envs.reach`: its joints go where they are sent, as servos do.

    Attributes:
        info: What the physics say after the last action: see :class:`aicon_envs.reach.ReachEnv`.
    """

    config_class = AiconSimulatedConfig
    name = "aicon_simulated"

    def __init__(self, config: AiconSimulatedConfig) -> None:
        super().__init__(config)
        check_positive(config, ("fps",))
        self.config = config
        self._env = ReachEnv(config.robot, "axis", "random", speed=10.0)
        self._keys = [f"{joint}.pos" for joint in self._env.description()["joints"]]
        self._sizes = {
            name: (camera.width or PICTURE[0], camera.height or PICTURE[1])
            for name, camera in config.cameras.items()
        }
        self._is_connected = False
        self._film: list[Any] = []
        self.info: dict[str, Any] = {}

    @property
    def observation_features(self) -> dict[str, Any]:
        """The angle of each joint, degrees, the gripper's opening, and the cameras' pictures."""
        shapes = {name: (height, width, 3) for name, (width, height) in self._sizes.items()}
        return self.action_features | shapes

    @property
    def action_features(self) -> dict[str, Any]:
        """Where each joint shall go, degrees, and how far the gripper shall open."""
        return dict.fromkeys([*self._keys, *([GRIPPER] if self.config.gripper else [])], float)

    @property
    def cameras(self) -> dict[str, Any]:
        """The cameras, by their names."""
        return dict(self.config.cameras)

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
        self._joints, self._gripper = observation["q"], 0.0
        self._goal = dict(zip(self._keys, np.degrees(self._joints).tolist(), strict=True))
        self._is_connected, self._sent = True, 0

    def calibrate(self) -> None:
        """Nothing."""

    def configure(self) -> None:
        """Nothing."""

    def disconnect(self) -> None:
        """End the episode, and save the film of it."""
        self._is_connected = False
        if self.config.film is not None and self._film:
            from aicon_baselines.figures.rendering import save_video

            save_video(self._film, self.config.film, round(self.config.fps / FILMED))
            self._film = []

    def get_observation(self) -> dict[str, Any]:
        """The angles of the joints, degrees, the gripper's opening, and pictures ``(h, w, 3)``."""
        self._check_connected()
        observation = dict(zip(self._keys, np.degrees(self._joints).tolist(), strict=True))
        if self.config.gripper:
            observation[GRIPPER] = self._gripper
        for name, size in self._sizes.items():
            observation[name] = self._env.picture("outside", size)
        return observation

    def send_action(self, action: dict[str, Any]) -> dict[str, Any]:
        """Let the servos go there for one step of LeRobot's loop.

        A motor that is left out, or has no finite number, stays where it was sent.

        Raises:
            ValueError: If the action has no number for a motor.
        """
        self._check_connected()
        check_mapping("action", action, self._keys)
        told = finite(action)
        self._goal |= {key: float(told[key]) for key in self._keys if key in told}
        target = np.radians([self._goal[key] for key in self._keys])
        for _ in range(max(1, round(1 / self.config.fps / CONTROL_STEP))):
            observation, *_, self.info = self._env.step((target - self._joints) / SERVO)
            self._joints = observation["q"]
        self._gripper = float(np.clip(told.get(GRIPPER, self._gripper), 0.0, 100.0))
        self._sent += 1
        if self.config.film is not None and self._sent % FILMED == 0:
            self._film.append(self._env.picture("outside", PICTURE))
        return dict(action)

    def _check_connected(self) -> None:
        """Check that an episode has begun."""
        if not self._is_connected:
            raise DeviceNotConnectedError(f"{self.name} is not connected: call connect() first.")
