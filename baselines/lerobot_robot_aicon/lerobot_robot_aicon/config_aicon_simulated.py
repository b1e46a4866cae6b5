"""The options of a simulated arm."""

from dataclasses import dataclass, field
from pathlib import Path

from lerobot.cameras import CameraConfig
from lerobot.cameras.opencv.configuration_opencv import OpenCVCameraConfig
from lerobot.robots import RobotConfig

__all__ = ["AiconSimulatedConfig", "OpenCVCameraConfig"]  # the latter makes "type: opencv" known


@RobotConfig.register_subclass("aicon_simulated")
@dataclass(kw_only=True)
class AiconSimulatedConfig(RobotConfig):
    """An arm in MuJoCo, to try a shield without hardware.

    Attributes:
        robot: One of `aicon_envs.reach.ROBOTS`.
        gripper: Whether it has a gripper, which opens and closes and holds nothing.
        cameras: Those of the arm that it stands for. All of them look at it from outside.
        fps: Actions a second.
        seed: Of the posture in which it begins.
        film: Where to save what was seen from outside, an mp4; None saves nothing.
    """

    robot: str = "so101"
    gripper: bool = True
    cameras: dict[str, CameraConfig] = field(default_factory=dict)
    fps: int = 30
    seed: int = 0
    film: Path | None = None
