"""The options of a simulated arm."""

from dataclasses import dataclass

from lerobot.robots import RobotConfig


@RobotConfig.register_subclass("aicon_simulated")
@dataclass(kw_only=True)
class AiconSimulatedConfig(RobotConfig):
    """An arm in MuJoCo, to try a shield without hardware.

    Attributes:
        robot: One of `aicon_envs.reach.ROBOTS`.
        fps: Actions a second.
        seed: Of the posture in which it begins.
    """

    robot: str = "so101"
    fps: int = 30
    seed: int = 0
