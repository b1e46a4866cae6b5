"""The options of a shielded robot."""

from dataclasses import dataclass
from typing import Any

import draccus
from lerobot.robots import RobotConfig

from lerobot_robot_aicon.arm_options import ShieldOptions


class InnerRobot(draccus.ChoiceRegistry):
    """Any robot but a shielded one, of which the command line would be told without end."""

    @classmethod
    def get_known_choices(cls) -> dict[str, Any]:
        """The robots that LeRobot knows, by the names of their types."""
        known = RobotConfig.get_known_choices()
        return {name: kind for name, kind in known.items() if kind is not AiconShieldConfig}

    @classmethod
    def get_choice_class(cls, name: str) -> Any:
        """The configuration of a type."""
        return cls.get_known_choices()[name]

    @classmethod
    def get_choice_name(cls, subcls: Any) -> str:
        """The type of a configuration."""
        name: str = RobotConfig.get_choice_name(subcls)
        return name


@RobotConfig.register_subclass("aicon_shield")
@dataclass(kw_only=True)
class AiconShieldConfig(ShieldOptions, RobotConfig):
    """A robot of LeRobot, and what it must not do.

    Attributes:
        inner: The robot, as its own type is configured: `--robot.inner.type=so101_follower`.
    """

    inner: InnerRobot
