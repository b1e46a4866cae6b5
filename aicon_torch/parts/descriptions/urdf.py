"""Reads links and joints from URDF (https://wiki.ros.org/urdf/XML), in float64."""

from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from aicon_torch.errors import OptionError
from aicon_torch.parts.descriptions.link_tree import JointDescription, LinkTree


def read_urdf(source: str | Path) -> LinkTree:
    """The links and joints of a robot.

    Args:
        source: A file, or the text of one.

    Raises:
        FileNotFoundError: If there is no such file.
        OptionError: If it is no URDF, or its joints are no tree.
    """
    root = parse_xml(source, root_tag="robot")
    links = [str(link.get("name")) for link in root.findall("link")]
    joints = [_joint(element) for element in root.findall("joint")]
    return LinkTree(links, joints)


def parse_xml(source: str | Path, root_tag: str) -> ElementTree.Element:
    """The root element of a file or text.

    Raises:
        FileNotFoundError: If there is no such file.
        OptionError: If it is no XML, or its root has another tag.
    """
    is_text = isinstance(source, str) and source.lstrip().startswith("<")
    name = "The text" if is_text else str(source)
    text = str(source).encode() if is_text else Path(source).read_bytes()

    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise OptionError(f"{name} is no XML: {error}.") from error

    if root.tag != root_tag:
        raise OptionError(f"{name} begins with <{root.tag}>: expected <{root_tag}>.")
    return root


def origin_of(element: ElementTree.Element) -> NDArray[Any]:
    """The transform ``(4, 4)`` in the child ``<origin>``, m; the identity if there is none.

    Angles are roll, pitch and yaw: R = R_z(yaw) R_y(pitch) R_x(roll).
    """
    origin = element.find("origin")
    transform = np.eye(4)
    if origin is None:
        return transform

    roll, pitch, yaw = _numbers(origin, "rpy", (0.0, 0.0, 0.0))
    turn_x = [
        [1.0, 0.0, 0.0],
        [0.0, np.cos(roll), -np.sin(roll)],
        [0.0, np.sin(roll), np.cos(roll)],
    ]
    turn_y = [
        [np.cos(pitch), 0.0, np.sin(pitch)],
        [0.0, 1.0, 0.0],
        [-np.sin(pitch), 0.0, np.cos(pitch)],
    ]
    turn_z = [
        [np.cos(yaw), -np.sin(yaw), 0.0],
        [np.sin(yaw), np.cos(yaw), 0.0],
        [0.0, 0.0, 1.0],
    ]

    transform[:3, :3] = np.array(turn_z) @ np.array(turn_y) @ np.array(turn_x)
    transform[:3, 3] = _numbers(origin, "xyz", (0.0, 0.0, 0.0))
    return transform


def _joint(element: ElementTree.Element) -> JointDescription:
    """One joint of the file."""
    name, kind = str(element.get("name")), str(element.get("type"))
    low, high, speed = _limits(element, kind)

    mimic = element.find("mimic")
    return JointDescription(
        name=name,
        kind=kind,
        parent=_link_of(element, "parent"),
        child=_link_of(element, "child"),
        fixed=origin_of(element),
        axis=_axis(element, name),
        low=low,
        high=high,
        speed=speed,
        mimics=None if mimic is None else str(mimic.get("joint")),
    )


def _link_of(element: ElementTree.Element, end: str) -> str:
    """The link at one end of a joint."""
    found = element.find(end)
    if found is None:
        raise OptionError(f"Joint {element.get('name')!r} has no <{end}>.")
    return str(found.get("link"))


def _axis(element: ElementTree.Element, name: str) -> NDArray[Any]:
    """The axis as a unit vector; x where the file names none, as URDF has it."""
    axis = element.find("axis")
    x_axis = (1.0, 0.0, 0.0)
    direction = np.array(x_axis if axis is None else _numbers(axis, "xyz", x_axis))

    length = float(np.linalg.norm(direction))
    if length == 0.0 and element.get("type") != "fixed":
        raise OptionError(f"Joint {name!r} has the axis (0, 0, 0): expected a direction.")
    return direction / length if length > 0.0 else np.array(x_axis)


def _limits(element: ElementTree.Element, kind: str) -> tuple[float, float, float]:
    """The lowest q, the highest q, and the largest speed."""
    limit = element.find("limit")
    if limit is None:
        return -np.inf, np.inf, np.inf

    speed = float(limit.get("velocity", np.inf))
    if kind == "continuous":  # it has no ends, whatever the file says
        return -np.inf, np.inf, speed
    return float(limit.get("lower", 0.0)), float(limit.get("upper", 0.0)), speed


def _numbers(
    element: ElementTree.Element, attribute: str, default: tuple[float, ...]
) -> tuple[float, ...]:
    """The numbers of an attribute, as many as the default has."""
    text = element.get(attribute)
    if text is None:
        return default

    numbers = tuple(float(number) for number in text.split())
    if len(numbers) != len(default):
        raise OptionError(f"{attribute}={text!r}: expected {len(default)} numbers.")
    return numbers
