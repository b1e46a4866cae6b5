"""How large a Collada file becomes when it is read: its nodes may contain each other again."""

import math
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

Elements = dict[str, ElementTree.Element]


class SceneSize(NamedTuple):
    """What is in a scene, each thing as often as it is instantiated; ∞ where it contains itself.

    Attributes:
        nodes: The number of nodes and geometries.
        triangles: At most so many triangles.
    """

    nodes: float
    triangles: float


def size_of_scene(path: Path) -> SceneSize:
    """What is in the scenes of a file.

    Args:
        path: The file.

    Raises:
        xml.etree.ElementTree.ParseError: If it is no XML.
        RecursionError: If nodes are nested too deeply.
    """
    root = ElementTree.parse(path).getroot()

    # What others refer to by name.
    named: Elements = {}
    for element in root.iter():
        if _tag(element) in ("node", "geometry"):
            named[f"#{element.get('id')}"] = element
    sizes: dict[ElementTree.Element, SceneSize] = {}

    # The size of an element with all below it, each counted once for every reference.
    def size(element: ElementTree.Element) -> SceneSize:
        if element not in sizes:
            sizes[element] = SceneSize(math.inf, math.inf)  # should it meet itself below
            below = [size(each) for each in _below(element, named)]
            sizes[element] = SceneSize(
                nodes=1 + sum(each.nodes for each in below),
                triangles=_triangles(element) + sum(each.triangles for each in below),
            )
        return sizes[element]

    scenes = [size(element) for element in root.iter() if _tag(element) == "visual_scene"]
    return SceneSize(sum(each.nodes for each in scenes), sum(each.triangles for each in scenes))


def _below(element: ElementTree.Element, named: Elements) -> list[ElementTree.Element]:
    """The nodes within a node or scene, and the nodes and geometries that it instantiates."""
    below = [child for child in element if _tag(child) == "node"]
    for child in element:
        if _tag(child) in ("instance_node", "instance_geometry") and child.get("url") in named:
            below.append(named[str(child.get("url"))])
    return below


def _triangles(element: ElementTree.Element) -> int:
    """The triangles of a geometry, which has three corners or more, of one number or more, each."""
    if _tag(element) != "geometry":
        return 0
    return sum(len((part.text or "").split()) for part in element.iter() if _tag(part) == "p") // 3


def _tag(element: ElementTree.Element) -> str:
    """The tag without its namespace."""
    return element.tag.rpartition("}")[2]
