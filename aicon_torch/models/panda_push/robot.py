"""The robot as plain data: by default a Panda with the stick and camera of `aicon/PandaPush-v0`.

A test compares these numbers with those that the physics use.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from aicon_torch.parts.camera import Intrinsics
from aicon_torch.parts.joint_product import Transform
from aicon_torch.parts.self_collision import Capsule

JOINT_FRAMES: tuple[Transform, ...] = (
    ((1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.333)),
    ((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0), (0.0, -1.0, 0.0, 0.0)),
    ((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, -1.0, -0.316), (0.0, 1.0, 0.0, 0.0)),
    ((1.0, 0.0, 0.0, 0.0825), (0.0, 0.0, -1.0, 0.0), (0.0, 1.0, 0.0, 0.0)),
    ((1.0, 0.0, 0.0, -0.0825), (0.0, 0.0, 1.0, 0.384), (0.0, -1.0, 0.0, 0.0)),
    ((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, -1.0, 0.0), (0.0, 1.0, 0.0, 0.0)),
    ((1.0, 0.0, 0.0, 0.088), (0.0, 0.0, -1.0, 0.0), (0.0, 1.0, 0.0, 0.0)),
)

TOOL: Transform = ((1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.107))

CAMERA: Transform = (
    (0.0, -0.995004165, -0.099833417, 0.06),
    (1.0, 0.0, 0.0, 0.0),
    (0.0, -0.099833417, 0.995004165, 0.03),
)

INTRINSICS = Intrinsics(85.688880405, 79.5, 59.5, 160.0, 120.0)

CAPSULES: tuple[Capsule, ...] = (
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


@dataclass(frozen=True)
class Robot:
    """An arm with a stick and a camera in its hand.

    Attributes:
        frames: For each joint the transform from the previous link; then the link turns about z.
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
    """

    frames: tuple[Transform, ...] = JOINT_FRAMES
    tool: Transform = TOOL
    camera: Transform = CAMERA
    intrinsics: Intrinsics = INTRINSICS
    low: tuple[float, ...] = (-2.8973, -1.7628, -2.8973, -3.0718, -2.8973, -0.0175, -2.8973)
    high: tuple[float, ...] = (2.8973, 1.7628, 2.8973, -0.0698, 2.8973, 3.7525, 2.8973)
    speed: tuple[float, ...] = (2.175, 2.175, 2.175, 2.175, 2.61, 2.61, 2.61)
    capsules: tuple[Capsule, ...] = CAPSULES
    stick_length: float = 0.30
    stick_radius: float = 0.015
    tool_mass: float = 0.25
    reach: float = 0.801

    @classmethod
    def from_description(cls, description: Mapping[str, Any]) -> "Robot":
        """The robot of a description whose keys are these attributes, as an environment gives it.

        Args:
            description: Plain numbers; transforms may have a fourth row, which is left out. What is
                missing is as on a Panda.
        """
        numbers = dict(description)
        numbers["frames"] = tuple(_three_rows(frame) for frame in description["frames"])
        numbers["tool"] = _three_rows(description["tool"])
        numbers["camera"] = _three_rows(description["camera"])
        numbers["intrinsics"] = Intrinsics(*description["intrinsics"])
        numbers["capsules"] = tuple(Capsule(*capsule) for capsule in description["capsules"])
        return cls(**numbers)


def _three_rows(transform: Transform) -> Transform:
    return tuple(tuple(row) for row in transform[:3])


PANDA = Robot()
"""A Franka Emika Panda."""
