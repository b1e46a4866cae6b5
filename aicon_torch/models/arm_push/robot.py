"""The robot as plain data; named is the Panda with the stick and camera of `aicon/ArmPush-v0`.

A test compares its numbers with those that the physics use.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

from aicon_torch.errors import OptionError, choices
from aicon_torch.parts.camera import Intrinsics
from aicon_torch.parts.capsules import Capsules
from aicon_torch.parts.chain import Chain, Joint
from aicon_torch.parts.joint_product import Transform
from aicon_torch.parts.self_collision import FREE_LINKS, Capsule, Point

Z_AXIS: Point = (0.0, 0.0, 1.0)


@dataclass(frozen=True)
class Robot:
    """An arm of n joints with a stick and a camera in its hand.

    Attributes:
        frames: For each joint the transform from the previous link.
        tool: That of the tool in the last link; z points along the stick.
        camera: That of the camera in the tool: z into the image, x to its right, y down.
        intrinsics: Of the camera.
        low: Lower joint limits, rad.
        high: Upper joint limits, rad.
        speed: Speed limits of the joints, rad/s.
        capsules: The shape of the robot.
        stick_length: Length of the stick, m.
        stick_radius: Radius of the stick, m.
        tool_mass: Mass of stick, camera and mount, kg.
        reach: Distance of the tip from the axis of the base where the arm is straight and the stick
            upright, m.
        nearest: Least distance of the tip from that axis where the stick is upright, m.
        axes: What each link turns about, unit vectors in its frame; None for z throughout.
        pairs: Numbers of the capsules that can meet; None for all whose links are far apart in the
            chain, as :class:`aicon_torch.parts.self_collision.SelfCollision` has it.

    Raises:
        OptionError: If there is not one number or axis for each joint.
    """

    frames: tuple[Transform, ...]
    tool: Transform
    camera: Transform
    intrinsics: Intrinsics
    low: tuple[float, ...]
    high: tuple[float, ...]
    speed: tuple[float, ...]
    capsules: tuple[Capsule, ...]
    stick_length: float
    stick_radius: float
    tool_mass: float
    reach: float
    nearest: float
    axes: tuple[Point, ...] | None = None
    pairs: tuple[tuple[int, int], ...] | None = None

    def __post_init__(self) -> None:
        """Check that every joint is told all of it."""
        count = len(self.frames)
        for name in ("low", "high", "speed", "axes"):
            values = getattr(self, name)
            if values is not None and len(values) != count:
                raise OptionError(
                    f"robot.{name} has {len(values)} of them: expected {count}, as robot.frames."
                )

    def chain(self) -> Chain:
        """The chain from the joints to the tool."""
        axes = self.axes or (Z_AXIS,) * len(self.frames)
        joints = [Joint(f"joint_{number}", axis) for number, axis in enumerate(axes, start=1)]
        return Chain(self.frames, self.tool, joints)

    @classmethod
    def from_description(cls, description: Mapping[str, Any]) -> "Robot":
        """The robot of a description whose keys are these attributes, as an environment gives it.

        Args:
            description: Plain numbers; transforms may have a fourth row, which is left out.
                ``collisions`` may name the ``urdf``, ``srdf`` and ``tip`` of the arm: capsules are
                then fitted to its collision geometry, and those told are the tool's.

        Raises:
            FileNotFoundError: If a file or mesh is missing.
            ModuleNotFoundError: If an extra package is missing.
            OptionError: If something is missing, or is no attribute of a robot.
        """
        numbers = dict(description)
        collisions = numbers.pop("collisions", None)
        _check_names(numbers, cls)

        for name in ("tool", "camera"):
            numbers[name] = _three_rows(numbers[name])
        numbers["frames"] = tuple(_three_rows(frame) for frame in numbers["frames"])
        numbers["intrinsics"] = Intrinsics(*numbers["intrinsics"])
        numbers["capsules"] = tuple(Capsule(*capsule) for capsule in numbers["capsules"])

        if collisions is not None:
            names = (collisions["urdf"], collisions["srdf"], collisions["tip"])
            shape = Capsules.from_urdf(*names)
            numbers["pairs"] = (*shape.pairs, *_pairs_with_tool(shape, numbers["capsules"]))
            numbers["capsules"] = (*shape.capsules, *numbers["capsules"])
        return cls(**numbers)


def _check_names(numbers: Mapping[str, Any], kind: type[Robot]) -> None:
    """Check that a description has what a robot is told, and nothing else."""
    needed = [field.name for field in fields(kind)][:-2]  # axes and pairs have defaults
    missing = [name for name in needed if name not in numbers]
    unknown = set(numbers) - {field.name for field in fields(kind)}
    if missing:
        raise OptionError(f"The description of the robot lacks {choices(missing)}.")
    if unknown:
        raise OptionError(
            f"The description of the robot has {choices(sorted(unknown))}: expected "
            f"{choices(needed)}."
        )


def _pairs_with_tool(shape: Capsules, tool: Sequence[Capsule]) -> list[tuple[int, int]]:
    """The pairs of an arm's capsules and its tool's, which come after them, that can meet."""
    pairs: list[tuple[int, int]] = []
    for number, capsule in enumerate(shape.capsules):
        for index, other in enumerate(tool, start=len(shape.capsules)):
            carrier = other.link - 1  # the link that the tool is fixed to
            if carrier - capsule.link > FREE_LINKS:
                pairs.append((number, index))
    return pairs


def _three_rows(transform: Transform) -> Transform:
    return tuple(tuple(row) for row in transform[:3])


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

PANDA_INTRINSICS = Intrinsics(85.688880405, 79.5, 59.5, 160.0, 120.0)

PANDA_CAPSULES: tuple[Capsule, ...] = (
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

PANDA = Robot(
    frames=PANDA_FRAMES,
    tool=PANDA_TOOL,
    camera=PANDA_CAMERA,
    intrinsics=PANDA_INTRINSICS,
    low=(-2.8973, -1.7628, -2.8973, -3.0718, -2.8973, -0.0175, -2.8973),
    high=(2.8973, 1.7628, 2.8973, -0.0698, 2.8973, 3.7525, 2.8973),
    speed=(2.175, 2.175, 2.175, 2.175, 2.61, 2.61, 2.61),
    capsules=PANDA_CAPSULES,
    stick_length=0.30,
    stick_radius=0.015,
    tool_mass=0.25,
    reach=0.801,
    nearest=0.266,
)
"""A Franka Emika Panda."""
