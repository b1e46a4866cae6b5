"""How large a Collada file becomes when it is read: its nodes may contain each other again."""

import math
from pathlib import Path
from xml.etree import ElementTree


def count_nodes(path: Path) -> float:
    """The number of nodes in the scene of a file, each as often as it is instantiated.

    Args:
        path: The file.

    Returns:
        The number; ∞ where a node contains itself.

    Raises:
        xml.etree.ElementTree.ParseError: If it is no XML.
        RecursionError: If nodes are nested too deeply.
    """
    root = ElementTree.parse(path).getroot()
    nodes = {f"#{element.get('id')}": element for element in root.iter() if _tag(element) == "node"}
    counts: dict[ElementTree.Element, float] = {}

    def count(element: ElementTree.Element) -> float:
        if element not in counts:
            counts[element] = math.inf  # should it meet itself below
            counts[element] = 1.0 + sum(map(count, _below(element, nodes)))
        return counts[element]

    scenes = [element for element in root.iter() if _tag(element) == "visual_scene"]
    return sum(map(count, scenes))


def _below(
    element: ElementTree.Element, nodes: dict[str, ElementTree.Element]
) -> list[ElementTree.Element]:
    """The nodes within a node or scene, and those that it instantiates."""
    below = [child for child in element if _tag(child) == "node"]
    for child in element:
        if _tag(child) == "instance_node" and child.get("url") in nodes:
            below.append(nodes[str(child.get("url"))])
    return below


def _tag(element: ElementTree.Element) -> str:
    """The tag without its namespace."""
    return element.tag.rpartition("}")[2]
