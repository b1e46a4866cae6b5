"""Checks of a robot's description (URDF): errors name the file and the element."""

import math
from collections import Counter
from pathlib import Path
from xml.etree import ElementTree

Element = ElementTree.Element

LARGEST_FILE = 10_000_000
"""Bytes of a description; the largest of example-robot-data has 100 kB."""

LARGEST_MESH = 60_000_000
"""Bytes of a mesh: a million triangles as STL."""

MOST_LINKS = 1000
"""Of one robot; the most in example-robot-data is 130."""

MESHES = (".stl", ".dae", ".obj", ".ply", ".off")
"""The endings that are read. Archives and glTF are not: unpacked, one may have any size."""

MOVING = ("revolute", "continuous", "prismatic")
"""The kinds of joints with one degree of freedom."""

_PLACES = ("xyz", "rpy", "radius", "length", "size", "scale", "value")
INERTIA = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
"""The components of an inertia, kg m²."""

_LIMITS = ("lower", "upper", "velocity")
_LARGEST = 1e9  # m, rad, kg, kg m²: what is larger is no robot


def parse_description(file: Path) -> Element:
    """Return the root element of a file whose links and joints are a tree.

    Raises:
        ValueError: If the file is no XML or too large, or has too many links, a name twice, a link
            with two joints above it, or joints in a loop.
    """
    check_size(file, LARGEST_FILE)
    try:
        root = ElementTree.parse(file).getroot()
    except (ElementTree.ParseError, LookupError, ValueError) as error:  # or an unknown encoding
        raise ValueError(f"{file.name} is no XML: {error}") from error

    links = root.findall("link")
    if len(links) > MOST_LINKS:
        raise ValueError(f"{file.name} has {len(links)} links; at most {MOST_LINKS} are expected")
    for kind in ("link", "joint"):
        counts = Counter(element.get("name") for element in root.findall(kind))
        name, count = max(counts.items(), key=lambda item: item[1], default=(None, 0))
        if count > 1:
            raise ValueError(f"{file.name} has {count} of the {kind} {name!r}; one is expected")

    _check_tree(root, file)
    return root


def check_size(file: Path, largest: int) -> None:
    """Check that a file is not too large.

    Raises:
        ValueError: If it is.
    """
    size = file.stat().st_size
    if size > largest:
        raise ValueError(
            f"{file} has {size / 1e6:.0f} MB; at most {largest / 1e6:.0f} MB are expected"
        )


def check_mesh(file: Path) -> None:
    """Check the format and the size of a mesh.

    Raises:
        ValueError: If they are not what is read.
    """
    if file.suffix.lower() not in MESHES:
        raise ValueError(f"the mesh {file} must end in one of {', '.join(MESHES)}")
    check_size(file, LARGEST_MESH)


def check_numbers(root: Element, file: Path) -> None:
    """Check the numbers of all links and joints.

    Raises:
        ValueError: If one is none or, but for limits, not finite.
    """
    for kind in ("link", "joint"):
        for owner in root.findall(kind):
            for element in owner.iter():
                _check_attributes(element, f"{file.name}: {kind} {owner.get('name')!r}")


def check_moving(joint: Element, file: Path) -> None:
    """Check a joint between root and tip.

    Raises:
        ValueError: If it has not one degree of freedom, or no room between its limits.
    """
    called, kind = f"{file.name}: joint {joint.get('name')!r}", joint.get("type")
    if kind not in MOVING:
        raise ValueError(f"{called} must be one of {', '.join(MOVING)}, got {kind!r}")
    if kind == "continuous":
        return

    # URDF takes 0 for a limit that is not named.
    limit = joint.find("limit")
    numbers = {} if limit is None else limit.attrib
    low, high = float(numbers.get("lower", 0.0)), float(numbers.get("upper", 0.0))
    if not low < high:
        raise ValueError(
            f"{called} must have a lower limit below the upper one, got {low:g} and {high:g}"
        )


def _check_tree(root: Element, file: Path) -> None:
    """Check that each link has one joint above it at most, and that going up ends."""
    above: dict[str | None, Element] = {}
    for joint in root.findall("joint"):
        child = link_name(joint, "child")
        if child in above:
            names = f"{above[child].get('name')!r} and {joint.get('name')!r}"
            raise ValueError(f"{file.name}: link {child!r} has the joints {names} above it")
        above[child] = joint

    for link in above:
        climbed = {link}
        while link in above:
            joint, link = above[link], link_name(above[link], "parent")
            if link in climbed:
                raise ValueError(f"{file.name}: joint {joint.get('name')!r} closes a loop")
            climbed.add(link)


def link_name(joint: Element, tag: str) -> str:
    """Return the name of the link above ("parent") or below ("child") a joint."""
    element = joint.find(tag)
    return "" if element is None else str(element.get("link"))


def _check_attributes(element: Element, called: str) -> None:
    for name in (*_PLACES, *INERTIA, *_LIMITS):
        for word in element.get(name, "").split():
            largest = math.inf if name in _LIMITS else _LARGEST
            if not abs(_number(word)) <= largest:
                text = element.get(name)
                raise ValueError(f"{called}: <{element.tag} {name}={text!r}> must be numbers")


def _number(word: str) -> float:
    """Return a word as a number, NaN where it is none."""
    try:
        return float(word)
    except ValueError:
        return math.nan
