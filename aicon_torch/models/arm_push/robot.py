"""The robot that pushes; named is the Panda with the stick and camera of `aicon/ArmPush-v0`.

A test compares its numbers with those that the physics use.
"""

from collections.abc import Mapping, Sequence, Sized
from dataclasses import dataclass
from typing import Any

import numpy as np

from aicon_torch.errors import OptionError, choices
from aicon_torch.parts.camera import Intrinsics
from aicon_torch.parts.capsules import Capsules
from aicon_torch.parts.chain import Chain, Joint
from aicon_torch.parts.joint_product import Transform
from aicon_torch.parts.robot import Robot
from aicon_torch.parts.self_collision import FREE_LINKS, Capsule, distant_pairs
from aicon_torch.validation import check_not_negative, check_positive, numbers

JOINTS = ("frames", "low", "high", "speed")
"""What a description says of each joint, besides its axis: z by default."""

TOOL = ("stick_length", "stick_radius", "tool_mass", "reach", "nearest")
"""What it says of the tool in one number each."""

NEEDED = (*JOINTS, "tool", "camera", "intrinsics", "capsules", *TOOL)


@dataclass(frozen=True, eq=False, kw_only=True)
class PushingRobot(Robot):
    """A robot with a stick and a camera in its hand. Build one with :meth:`from_description`.

    The chain ends in the tool, whose z points along the stick; its capsules belong to the shape.

    Attributes:
        camera: The transform of the camera in the tool: z into the image, x to its right, y down.
        intrinsics: Of the camera.
        stick_length: Length of the stick, m.
        stick_radius: Radius of the stick, m.
        tool_mass: Mass of stick, camera and mount, kg.
        reach: Distance of the tip from the axis of the base where the arm is straight and the stick
            upright, m.
        nearest: Least distance of the tip from that axis where the stick is upright, m.

    Raises:
        OptionError: If a length or the mass is none.
    """

    shape: Capsules
    camera: Transform
    intrinsics: Intrinsics
    stick_length: float
    stick_radius: float
    tool_mass: float
    reach: float
    nearest: float

    def __post_init__(self) -> None:
        """Check the numbers."""
        check_positive(self, ("stick_length", "stick_radius", "reach"))
        check_not_negative(self, ("tool_mass", "nearest"))

    @classmethod
    def from_description(cls, description: Mapping[str, Any]) -> "PushingRobot":
        """The robot of a description, as an environment gives it.

        Args:
            description: Plain numbers. For each joint: ``frames``, the transform from the previous
                link; ``axes``, what the link turns about, z throughout if left out; ``low``,
                ``high``, rad; ``speed``, rad/s. The transform of the ``tool`` in the last link; its
                ``capsules``, or those of the whole robot; and the attributes. ``collisions`` may
                name the ``urdf``, ``srdf`` and ``tip`` of the arm: capsules are then fitted to its
                collision geometry, and those given are the tool's.

        Raises:
            FileNotFoundError: If a file or mesh is missing.
            ModuleNotFoundError: If an extra package is missing.
            OptionError: If something is missing or unknown, is not there for each joint, or is no
                number or transform.
        """
        _check_names(description)
        _check_transforms(description)
        numbers("intrinsics", description["intrinsics"], 5)
        count = len(description["frames"])
        axes = description.get("axes") or ((0.0, 0.0, 1.0),) * count
        _check_count({**description, "axes": axes}, count)

        # Low, high and speed of each joint, in the order in which a Joint has them.
        ranges = zip(*(description[name] for name in JOINTS[1:]), strict=True)
        joints: list[Joint] = []
        for number, (axis, limits) in enumerate(zip(axes, ranges, strict=True), start=1):
            joints.append(Joint(f"joint_{number}", tuple(axis), False, *limits))

        return cls(
            chain=Chain(description["frames"], description["tool"], joints),
            shape=_shape(description),
            camera=tuple(tuple(row) for row in description["camera"][:3]),
            intrinsics=Intrinsics(*description["intrinsics"]),
            **{name: description[name] for name in TOOL},
        )


def _check_names(description: Mapping[str, Any]) -> None:
    """Check that a description has what a robot needs, and nothing else."""
    missing = [name for name in NEEDED if name not in description]
    unknown = set(description) - {*NEEDED, "axes", "collisions"}
    if missing:
        raise OptionError(f"The description of the robot lacks {choices(missing)}.")
    if unknown:
        raise OptionError(
            f"The description of the robot has {choices(sorted(unknown))}: expected "
            f"{choices(NEEDED)}."
        )


def _check_transforms(description: Mapping[str, Any]) -> None:
    """Check that what places a link, the tool or the camera does so."""
    for name, depth in (("frames", 3), ("tool", 2), ("camera", 2)):
        try:
            given = np.array(description[name], dtype=np.float64)
        except (TypeError, ValueError):  # no numbers, or not as many in each row
            given = np.empty(0)
        is_whole = given.ndim == depth and given.shape[-2:] in ((3, 4), (4, 4))
        if not is_whole or not np.isfinite(given).all():
            raise OptionError(
                f"robot.{name}={description[name]!r}: expected three rows of four finite numbers"
                + (" for each joint." if name == "frames" else ".")
            )


def _check_count(description: Mapping[str, Any], count: int) -> None:
    """Check that all of it is given for every joint."""
    for name in (*JOINTS, "axes"):
        given = len(description[name]) if isinstance(description[name], Sized) else 0
        if given != count:
            raise OptionError(
                f"robot.{name} has {given} of them: expected {count}, as robot.frames."
            )


def _shape(description: Mapping[str, Any]) -> Capsules:
    """The capsules of arm and tool, and those of them that can meet."""
    given = tuple(Capsule(*capsule) for capsule in description["capsules"])
    files = description.get("collisions")

    # Without files, the capsules that are given are those of the whole robot.
    if files is None:
        links = tuple(f"link {capsule.link}" for capsule in given)
        return Capsules(given, links, tuple(distant_pairs(given)))

    arm = Capsules.from_urdf(files["urdf"], files["srdf"], files["tip"])
    pairs = (*arm.pairs, *_pairs_with_tool(arm, given))
    return Capsules((*arm.capsules, *given), (*arm.links, *["tool"] * len(given)), pairs)


def _pairs_with_tool(shape: Capsules, tool: Sequence[Capsule]) -> list[tuple[int, int]]:
    """The pairs of an arm's capsules and its tool's, which come after them, that can meet."""
    pairs: list[tuple[int, int]] = []
    for number, capsule in enumerate(shape.capsules):
        for index, other in enumerate(tool, start=len(shape.capsules)):
            carrier = other.link - 1  # the link that the tool is fixed to
            if carrier - capsule.link > FREE_LINKS:
                pairs.append((number, index))
    return pairs


# For each joint the transform from the link before it; the last column is the position, m.
PANDA_FRAMES: tuple[Transform, ...] = (
    ((1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.333)),
    ((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0), (0.0, -1.0, 0.0, 0.0)),
    ((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, -1.0, -0.316), (0.0, 1.0, 0.0, 0.0)),
    ((1.0, 0.0, 0.0, 0.0825), (0.0, 0.0, -1.0, 0.0), (0.0, 1.0, 0.0, 0.0)),
    ((1.0, 0.0, 0.0, -0.0825), (0.0, 0.0, 1.0, 0.384), (0.0, -1.0, 0.0, 0.0)),
    ((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, -1.0, 0.0), (0.0, 1.0, 0.0, 0.0)),
    ((1.0, 0.0, 0.0, 0.088), (0.0, 0.0, -1.0, 0.0), (0.0, 1.0, 0.0, 0.0)),
)

PANDA_TOOL: Transform = ((1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.107))

PANDA_CAMERA: Transform = (
    (0.0, -0.995004165, -0.099833417, 0.06),
    (1.0, 0.0, 0.0, 0.0),
    (0.0, -0.099833417, 0.995004165, 0.03),
)

# The links from the base on, and last the tool: the stick and the camera.
PANDA_CAPSULES = (
    Capsule(0, (-0.09, 0.0, 0.06), (-0.06, 0.0, 0.06), 0.09),
    Capsule(1, (0.0, 0.0, -0.333), (0.0, 0.0, -0.05), 0.09),
    Capsule(2, (0.0, 0.0, -0.06), (0.0, 0.0, 0.06), 0.09),
    Capsule(3, (0.0, 0.0, -0.22), (0.0, 0.0, -0.07), 0.09),
    Capsule(4, (0.0, 0.0, -0.06), (0.0, 0.0, 0.06), 0.09),
    Capsule(5, (0.0, 0.0, -0.31), (0.0, 0.0, -0.21), 0.09),
    Capsule(5, (0.0, 0.08, -0.2), (0.0, 0.08, -0.06), 0.055),
    Capsule(6, (0.0, 0.0, -0.07), (0.0, 0.0, 0.01), 0.08),
    Capsule(7, (0.0, 0.0, -0.06), (0.0, 0.0, 0.08), 0.07),
    Capsule(
        7,
        (0.043534125, 0.04353694, 0.089996018),
        (0.036465875, 0.03646306, 0.090003982),
        0.045,
    ),
    Capsule(8, (0.0, 0.0, 0.0), (0.0, 0.0, 0.285), 0.015),
    Capsule(8, (0.06, -0.015, 0.01), (0.06, 0.015, 0.01), 0.025),
)

PANDA = PushingRobot.from_description(
    {
        "frames": PANDA_FRAMES,
        "tool": PANDA_TOOL,
        "camera": PANDA_CAMERA,
        "intrinsics": (85.688880405, 79.5, 59.5, 160.0, 120.0),
        "low": (-2.8973, -1.7628, -2.8973, -3.0718, -2.8973, -0.0175, -2.8973),
        "high": (2.8973, 1.7628, 2.8973, -0.0698, 2.8973, 3.7525, 2.8973),
        "speed": (2.175, 2.175, 2.175, 2.175, 2.61, 2.61, 2.61),
        "capsules": PANDA_CAPSULES,
        "stick_length": 0.30,
        "stick_radius": 0.015,
        "tool_mass": 0.25,
        "reach": 0.801,
        "nearest": 0.266,
    }
)
"""A Franka Emika Panda."""
