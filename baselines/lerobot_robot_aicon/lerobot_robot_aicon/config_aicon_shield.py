"""The options of a shielded robot."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import draccus
from lerobot.robots import RobotConfig


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
class AiconShieldConfig(RobotConfig):
    """A robot of LeRobot, and what it must not do.

    Attributes:
        inner: The robot, as its own type is configured: `--robot.inner.type=so101_follower`.
        urdf: Its description, a file next to its meshes, or a name of `aicon_envs.reach.ROBOTS`,
            such as so101.
        tip: The link of the description that reaches; of a robot with a name it is known.
        srdf: Says which links of the description need not be compared.
        table: Height of a table in the frame of the base, m; None for no table.
        motors: Of each joint of the description the motor that turns it, where names differ.
        offsets: What a motor shows where the description has its joint at 0, degrees.
        speed: Largest speed of a joint, rad/s.
        fps: Actions a second.
        lead: How far what is commanded may run ahead of a joint, degrees.
        goes_around: Whether it goes around what is in the way, or stays there.
    """

    inner: InnerRobot
    urdf: str
    tip: str | None = None
    srdf: Path | None = None
    table: float | None = None
    motors: dict[str, str] = field(default_factory=dict)
    offsets: dict[str, float] = field(default_factory=dict)
    speed: float = 1.5
    fps: int = 30
    lead: float = 10.0
    goes_around: bool = True
