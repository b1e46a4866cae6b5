"""The robot as plain data. The default is a Panda with the stick and the camera of `aicon/PandaPush-v0`.

A test compares these numbers with those that the physics use.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

Row = tuple[float, float, float, float]
Point = tuple[float, float, float]
Capsule = tuple[int, Point, Point, float]
"""Link (0 is the base, 8 the tool), both ends in its frame (m), radius (m)."""

_FRAMES: tuple[tuple[Row, ...], ...] = (
    ((1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.333)),
    ((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0), (0.0, -1.0, 0.0, 0.0)),
    ((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, -1.0, -0.316), (0.0, 1.0, 0.0, 0.0)),
    ((1.0, 0.0, 0.0, 0.0825), (0.0, 0.0, -1.0, 0.0), (0.0, 1.0, 0.0, 0.0)),
    ((1.0, 0.0, 0.0, -0.0825), (0.0, 0.0, 1.0, 0.384), (0.0, -1.0, 0.0, 0.0)),
    ((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, -1.0, 0.0), (0.0, 1.0, 0.0, 0.0)),
    ((1.0, 0.0, 0.0, 0.088), (0.0, 0.0, -1.0, 0.0), (0.0, 1.0, 0.0, 0.0)),
)
_TOOL: tuple[Row, ...] = ((1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.107))
_CAMERA: tuple[Row, ...] = (
    (0.0, -0.995004165, -0.099833417, 0.06),
    (1.0, 0.0, 0.0, 0.0),
    (0.0, -0.099833417, 0.995004165, 0.03),
)
_INTRINSICS: tuple[float, ...] = (85.688880405, 79.5, 59.5, 160.0, 120.0)
_CAPSULES: tuple[Capsule, ...] = (
    (0, (-0.09, 0.0, 0.06), (-0.06, 0.0, 0.06), 0.09),
    (1, (0.0, 0.0, -0.333), (0.0, 0.0, -0.05), 0.09),
    (2, (0.0, 0.0, -0.06), (0.0, 0.0, 0.06), 0.09),
    (3, (0.0, 0.0, -0.22), (0.0, 0.0, -0.07), 0.09),
    (4, (0.0, 0.0, -0.06), (0.0, 0.0, 0.06), 0.09),
    (5, (0.0, 0.0, -0.31), (0.0, 0.0, -0.21), 0.09),
    (5, (0.0, 0.08, -0.2), (0.0, 0.08, -0.06), 0.055),
    (6, (0.0, 0.0, -0.07), (0.0, 0.0, 0.01), 0.08),
    (7, (0.0, 0.0, -0.06), (0.0, 0.0, 0.08), 0.07),
    (7, (0.043534125, 0.04353694, 0.089996018), (0.036465875, 0.03646306, 0.090003982), 0.045),
    (8, (0.0, 0.0, 0.0), (0.0, 0.0, 0.285), 0.015),
    (8, (0.06, -0.015, 0.01), (0.06, 0.015, 0.01), 0.025),
)


@dataclass(frozen=True)
class Robot:
    """An arm of seven joints with a stick and a camera.

    Attributes:
        frames: For each joint the first three rows of the transform from the previous link; then it turns about z.
        tool: Those of the tool in the last link; z points along the stick.
        camera: Those of the camera in the tool: z into the image, x to its right, y down.
        intrinsics: Focal length, centre (x, y), width and height of the image, px.
        low: Lower joint limits, rad.
        high: Upper joint limits, rad.
        speed: Speed limits, rad/s.
        capsules: The shape of the robot.
        stick_length: Length of the stick, m.
        stick_radius: Radius of the stick, m.
        tool_mass: Mass of stick, camera and mount, kg.
        reach: Distance of the tip from the axis of the base where the arm is straight and the stick upright, m.
    """

    frames: tuple[tuple[Row, ...], ...] = _FRAMES
    tool: tuple[Row, ...] = _TOOL
    camera: tuple[Row, ...] = _CAMERA
    intrinsics: tuple[float, ...] = _INTRINSICS
    low: tuple[float, ...] = (-2.8973, -1.7628, -2.8973, -3.0718, -2.8973, -0.0175, -2.8973)
    high: tuple[float, ...] = (2.8973, 1.7628, 2.8973, -0.0698, 2.8973, 3.7525, 2.8973)
    speed: tuple[float, ...] = (2.175, 2.175, 2.175, 2.175, 2.61, 2.61, 2.61)
    capsules: tuple[Capsule, ...] = _CAPSULES
    stick_length: float = 0.30
    stick_radius: float = 0.015
    tool_mass: float = 0.25
    reach: float = 0.801

    @classmethod
    def of(cls, description: Mapping[str, Any]) -> "Robot":
        """The robot of a description with these names; transforms may have a fourth row."""
        rows = {name: tuple(map(tuple, description[name][:3])) for name in ("tool", "camera")}
        frames = tuple(tuple(map(tuple, frame[:3])) for frame in description["frames"])
        return cls(**{**description, **rows, "frames": frames})


PANDA = Robot()
