"""Robots of LeRobot behind a shield; importing this registers `--robot.type=aicon_shield`."""

from lerobot_robot_aicon.aicon_shield import AiconShield
from lerobot_robot_aicon.aicon_simulated import AiconSimulated
from lerobot_robot_aicon.config_aicon_shield import AiconShieldConfig
from lerobot_robot_aicon.config_aicon_simulated import AiconSimulatedConfig

__all__ = ["AiconShield", "AiconShieldConfig", "AiconSimulated", "AiconSimulatedConfig"]
