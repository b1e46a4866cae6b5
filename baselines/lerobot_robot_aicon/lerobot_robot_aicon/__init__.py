"""Arms of LeRobot behind a shield.

Importing this registers `--robot.type=aicon_shield` and the steps of processors `aicon_shield` and
`aicon_ee_to_joints`.
"""

from lerobot_robot_aicon.aicon_shield import AiconShield
from lerobot_robot_aicon.aicon_simulated import AiconSimulated
from lerobot_robot_aicon.config_aicon_shield import AiconShieldConfig
from lerobot_robot_aicon.config_aicon_simulated import AiconSimulatedConfig
from lerobot_robot_aicon.end_effector_step import EndEffectorStep
from lerobot_robot_aicon.shield_step import ShieldStep

__all__ = [
    "AiconShield",
    "AiconShieldConfig",
    "AiconSimulated",
    "AiconSimulatedConfig",
    "EndEffectorStep",
    "ShieldStep",
]
