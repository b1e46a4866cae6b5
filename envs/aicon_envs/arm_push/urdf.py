"""The description of an arm (URDF) without what is at its flange."""

from functools import lru_cache
from xml.etree import ElementTree

from aicon_envs.reach.description_checks import link_name
from aicon_envs.reach.robots import Robot
from aicon_envs.reach.urdf import Description, read_description


@lru_cache(maxsize=8)
def load_arm(arm: Robot) -> Description:
    """Return the description of an arm whose flange is free.

    Raises:
        FileNotFoundError: If it or one of its meshes is not there.
        ModuleNotFoundError: If an extra package is missing.
        ValueError: As `read_description`.
    """
    description = read_description(arm)
    root = ElementTree.fromstring(description.text)
    _free_flange(root, arm.tip)

    # Links without a mass, such as most flanges, stay so.
    for compiler in root.iter("compiler"):
        del compiler.attrib["boundmass"], compiler.attrib["boundinertia"]
    return description._replace(text=ElementTree.tostring(root, encoding="unicode"))


def _free_flange(root: ElementTree.Element, flange: str) -> None:
    """Remove all links beyond the flange, and the joints between them."""
    beyond = [flange]
    for link in beyond:  # grows
        for joint in root.findall("joint"):
            if link_name(joint, "parent") == link:
                beyond.append(link_name(joint, "child"))
                root.remove(joint)

    for element in root.findall("link"):
        if element.get("name") in beyond[1:]:
            root.remove(element)
