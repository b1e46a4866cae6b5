"""Reads links and joints from URDF (https://wiki.ros.org/urdf/XML), in float64."""

from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from aicon_torch.errors import OptionError
from aicon_torch.parts.descriptions.attributes import limit_of, numbers_of, text_of
from aicon_torch.parts.descriptions.files import read_source
from aicon_torch.parts.descriptions.link_tree import JointDescription, LinkTree

XACRO = "wiki/xacro}"
"""How the namespace of a macro ends, which stands before its tag."""

MOST_LINKS = 1000
"""Of one robot; the most in example-robot-data is 130."""


def read_urdf(source: str | Path) -> LinkTree:
    """The links and joints of a robot.

    Args:
        source: A file, or the text of one.

    Raises:
        FileNotFoundError: If there is no such file.
        OptionError: If it is no URDF, is written with macros, has very many links, its joints are
            no tree, or a number is none; it names the joint and its element.
    """
    root = parse_xml(source, root_tag="robot")
    for element in root.iter():
        if XACRO in element.tag:
            raise OptionError(
                "The robot is written with macros of xacro, such as "
                f"<xacro:{element.tag.split('}')[-1]}>: expected the URDF that they make: "
                "xacro robot.urdf.xacro > robot.urdf."
            )
    count = len(root.findall("link"))
    if count > MOST_LINKS:
        raise OptionError(f"The robot has {count} links: expected at most {MOST_LINKS}.")

    links = [text_of(link, "name", "A link") for link in root.findall("link")]
    joints = [_joint(element) for element in root.findall("joint")]
    return LinkTree(links, joints)


def parse_xml(source: str | Path, root_tag: str) -> ElementTree.Element:
    """The root element of a file or text.

    Raises:
        FileNotFoundError: If there is no such file.
        OptionError: If it is no XML, too large, or its root has another tag.
    """
    name, text = read_source(source)
    try:
        root = ElementTree.fromstring(text)
    except (ElementTree.ParseError, LookupError, ValueError) as error:  # or an unknown encoding
        raise OptionError(f"{name} is no XML: {error}.") from error

    if root.tag != root_tag:
        raise OptionError(f"{name} begins with <{root.tag}>: expected <{root_tag}>.")
    return root


def origin_of(element: ElementTree.Element, owner: str) -> NDArray[Any]:
    """The transform ``(4, 4)`` in the child ``<origin>``, m; the identity if there is none.

    Angles are roll, pitch and yaw: R = R_z(yaw) R_y(pitch) R_x(roll).

    Args:
        element: The joint, or the collision geometry.
        owner: What an error calls it.

    Raises:
        OptionError: If a number is missing, or is not finite.
    """
    origin = element.find("origin")
    transform = np.eye(4)
    if origin is None:
        return transform

    roll, pitch, yaw = numbers_of(origin, "rpy", owner, (0.0, 0.0, 0.0))

    # About axes that do not turn along: first x, then y, then z.
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
    transform[:3, 3] = numbers_of(origin, "xyz", owner, (0.0, 0.0, 0.0))
    return transform


def _joint(element: ElementTree.Element) -> JointDescription:
    """One joint of the file."""
    name = text_of(element, "name", "A joint")
    owner = f"Joint {name!r}"
    kind = text_of(element, "type", owner)
    low, high, speed = _limits(element, kind, owner)

    mimic = element.find("mimic")
    return JointDescription(
        name=name,
        kind=kind,
        parent=_link_of(element, "parent", owner),
        child=_link_of(element, "child", owner),
        fixed=origin_of(element, owner),
        axis=_axis(element, owner),
        low=low,
        high=high,
        speed=speed,
        mimics=None if mimic is None else text_of(mimic, "joint", owner),
    )


def _link_of(element: ElementTree.Element, end: str, owner: str) -> str:
    """The link at one end of a joint."""
    found = element.find(end)
    if found is None:
        raise OptionError(f"{owner} has no <{end}>.")
    return text_of(found, "link", owner)


def _axis(element: ElementTree.Element, owner: str) -> NDArray[Any]:
    """The axis as a unit vector; x where the file names none, as URDF has it."""
    axis = element.find("axis")
    x_axis = (1.0, 0.0, 0.0)
    direction = np.array(x_axis) if axis is None else numbers_of(axis, "xyz", owner, x_axis)

    # Only a joint that is fixed can do without an axis.
    length = float(np.linalg.norm(direction))
    if length == 0.0 and element.get("type") != "fixed":
        raise OptionError(f"{owner} has the axis (0, 0, 0): expected a direction.")
    return direction / length if length > 0.0 else np.array(x_axis)


def _limits(element: ElementTree.Element, kind: str, owner: str) -> tuple[float, float, float]:
    """The lowest q, the highest q, and the largest speed.

    URDF asks for limits of what turns or slides, and takes 0 for an end that is not named.
    """
    limit = element.find("limit")
    has_ends = kind in ("revolute", "prismatic")
    if limit is None:
        return (0.0, 0.0, np.inf) if has_ends else (-np.inf, np.inf, np.inf)

    speed = limit_of(limit, "velocity", owner, np.inf)
    if speed < 0.0:
        raise OptionError(f"{owner}: <limit velocity='{speed:g}'>: expected a number from 0 up.")
    if not has_ends:  # a continuous joint has none, whatever the file says
        return -np.inf, np.inf, speed

    low, high = limit_of(limit, "lower", owner, 0.0), limit_of(limit, "upper", owner, 0.0)
    if low > high:
        raise OptionError(
            f"{owner}: <limit lower='{low:g}' upper='{high:g}'>: expected lower below upper."
        )
    return low, high, speed
