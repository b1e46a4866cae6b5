"""What an arm of LeRobot is, in the words of its description."""

from dataclasses import dataclass, field
from pathlib import Path

from aicon_envs.reach.robots import ROBOTS, find_file
from aicon_torch.parts import Robot
from aicon_torch.validation import check_not_negative, check_positive, numbers


@dataclass(kw_only=True)
class ArmOptions:
    """An arm, its motors, and how it is driven.

    Attributes:
        urdf: Its description, a file next to its meshes, or a name of `aicon_envs.reach.ROBOTS`,
            such as so101.
        tip: The link of the description that reaches; of a robot with a name it is known.
        srdf: A file that says which links of the description need not be compared.
        motors: Of each joint of the description the motor that turns it, where names differ.
        offsets: What a motor shows where the description has a joint at 0, degrees, by the joint.
        signs: -1 for each joint whose motor counts the other way round.
        speed: Largest speed of a joint, rad/s.
        fps: Actions a second.
        lead: How far what is commanded may run ahead of a joint, degrees.
    """

    urdf: str
    tip: str | None = None
    srdf: str | None = None
    motors: dict[str, str] = field(default_factory=dict)
    offsets: dict[str, float] = field(default_factory=dict)
    signs: dict[str, int] = field(default_factory=dict)
    speed: float = 1.5
    fps: int = 30
    lead: float = 10.0


@dataclass(kw_only=True)
class ShieldOptions(ArmOptions):
    """An arm, and what it must not do.

    Attributes:
        table: Height of a table in the frame of the base, m; None for no table.
        goes_around: Whether it goes around what is in the way, or stays there.
    """

    table: float | None = None
    goes_around: bool = True


def described_arm(options: ArmOptions) -> Robot:
    """The arm that is described.

    Raises:
        ValueError: If there is no such description, or an option has a value that it cannot have.
    """
    _check_numbers(options)
    known = ROBOTS.get(options.urdf)
    if known is None and not Path(options.urdf).is_file():
        raise ValueError(
            f"urdf={options.urdf!r} is no file: expected one, or one of {', '.join(ROBOTS)}."
        )
    if known is None:
        return Robot.from_urdf(options.urdf, tip=options.tip, srdf=options.srdf)

    for name in ("tip", "srdf"):
        given, own = getattr(options, name), getattr(known, name)
        if given is not None:
            raise ValueError(f"{name}={given!r}: {options.urdf} has {own!r}; leave it out.")
    srdf = None if known.srdf is None else find_file(known.srdf)
    return Robot.from_urdf(find_file(known.urdf), tip=known.tip, srdf=srdf)


def _check_numbers(options: ArmOptions) -> None:
    """Check the numbers among the options, all of which must be finite."""
    check_positive(options, ("speed", "fps"))
    check_not_negative(options, ("lead",))
    for joint, offset in options.offsets.items():
        numbers(f"offsets[{joint!r}]", offset, 1)
    if isinstance(options, ShieldOptions) and options.table is not None:
        numbers("table", options.table, 1)
