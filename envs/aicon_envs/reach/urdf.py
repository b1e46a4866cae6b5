"""The description of a robot (URDF), made ready for MuJoCo."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree import ElementTree

import numpy as np

from aicon_envs.reach.description_checks import (
    INERTIA,
    check_mesh,
    check_moving,
    check_numbers,
    link_name,
    parse_description,
)
from aicon_envs.reach.robots import Robot, find_file

Element = ElementTree.Element


class Description(NamedTuple):
    """What MuJoCo reads.

    Attributes:
        text: URDF in which only the joints between root and tip move, without pictures.
        assets: The meshes that it names, as STL.
        joints: The names of those joints, from the root on.
        speeds: Their largest speeds, rad/s or m/s; infinite where the file has none.
    """

    text: str
    assets: Mapping[str, bytes]
    joints: tuple[str, ...]
    speeds: tuple[float, ...]


def read_description(robot: Robot) -> Description:
    """Read the URDF of a robot.

    Raises:
        FileNotFoundError: If it or one of its meshes is not there.
        ModuleNotFoundError: If an extra package is missing.
        ValueError: If it is no description of a robot, a number or mesh in it is none, the tip is
            no link of it, or no joint is between it and the root.
    """
    file = find_file(robot.urdf)
    root = parse_description(file)
    check_numbers(root, file)

    # Only the joints on the way to the tip move.
    moving = _joints_to(root, robot.tip, file)
    for joint in moving:
        check_moving(joint, file)
    for joint in root.findall("joint"):
        if joint not in moving:
            joint.set("type", "fixed")  # grippers and wheels rest
        elif joint.get("type") == "continuous":
            _drop_ends(joint)

    # What MuJoCo would refuse, or not find.
    assets = _take_meshes(root, file)
    for link in root.findall("link"):
        _drop_impossible_inertia(link)
    _add_compiler_options(root)

    return Description(
        text=ElementTree.tostring(root, encoding="unicode"),
        assets=assets,
        joints=tuple(str(joint.get("name")) for joint in moving),
        speeds=tuple(_speed(joint) for joint in moving),
    )


def _joints_to(root: Element, tip: str, file: Path) -> list[Element]:
    """Return the joints that move the tip, the first from the root first."""
    links = [link.get("name") for link in root.findall("link")]
    if tip not in links:
        raise ValueError(f"tip must be a link of {file.name}, got {tip!r}")

    # Each link hangs on one joint.
    above = {}
    for joint in root.findall("joint"):
        above[link_name(joint, "child")] = joint

    path = []
    link = tip
    while link in above:
        path.append(above[link])
        link = link_name(above[link], "parent")

    moving = [joint for joint in reversed(path) if joint.get("type") != "fixed"]
    if not moving:
        raise ValueError(f"tip must be moved by a joint of {file.name}, and {tip!r} is not")
    return moving


def _drop_ends(joint: Element) -> None:
    """Take out the ends of a joint without ends, which MuJoCo before 4 would hold it within."""
    limit = joint.find("limit")
    if limit is not None:
        limit.attrib.pop("lower", None)
        limit.attrib.pop("upper", None)


def _speed(joint: Element) -> float:
    limit = joint.find("limit")
    speed = 0.0 if limit is None else float(limit.get("velocity", 0.0))
    return speed if speed > 0.0 else float("inf")


def _take_meshes(root: Element, file: Path) -> dict[str, bytes]:
    """Return the meshes that collide as STL, and name them so; take the pictures out."""
    assets: dict[str, bytes] = {}

    for link in root.findall("link"):
        for visual in link.findall("visual"):
            link.remove(visual)

        for mesh in link.iter("mesh"):
            source = _find_mesh(str(mesh.get("filename")), file.parent)
            name = f"{source.parent.name}_{source.stem}.stl"
            if name not in assets:
                assets[name] = _to_stl(source)
            mesh.set("filename", name)

    return assets


def _find_mesh(filename: str, folder: Path) -> Path:
    """Return the file of a mesh, whose package lies in one of the folders above the URDF."""
    scheme, _, path = filename.rpartition("://")
    candidates = [folder / path]
    if scheme == "package":
        _, _, inside = path.partition("/")
        for above in folder.parents:
            candidates += [above / path, above / inside]

    for candidate in candidates:
        if candidate.is_file():
            return candidate
    raise FileNotFoundError(f"the mesh {filename} is neither in {folder} nor in a folder above it")


def _to_stl(file: Path) -> bytes:
    """Return a mesh of any format as STL, in m where the file names its unit."""
    check_mesh(file)
    content = file.read_bytes()
    if _is_binary_stl(content):
        return content

    trimesh = _import_trimesh()
    try:
        mesh = trimesh.load_mesh(file)
        if mesh.units is not None:
            mesh.convert_units("meters")
        exported: bytes = mesh.export(file_type="stl")
    except ImportError:
        raise
    except Exception as error:  # each format's reader raises others
        kind = type(error).__name__
        raise ValueError(f"the mesh {file} cannot be read ({kind}: {error})") from error
    return exported


def _is_binary_stl(content: bytes) -> bool:
    """Whether this is what MuJoCo reads: a header, the number of triangles, 50 bytes for each."""
    count = int.from_bytes(content[80:84], "little")
    return len(content) == 84 + 50 * count


def _import_trimesh() -> Any:
    """Import trimesh, or say what to install."""
    try:
        import trimesh
    except ModuleNotFoundError as error:
        raise ModuleNotFoundError(
            f"{error.name} is missing; it comes with: pip install 'aicon-torch[reach]'",
            name=error.name,
        ) from error
    return trimesh


def _drop_impossible_inertia(link: Element) -> None:
    """Leave the inertia to MuJoCo where no body could have the one that the file states."""
    inertial = link.find("inertial")
    inertia = None if inertial is None else inertial.find("inertia")
    if inertial is None or inertia is None:
        return

    xx, xy, xz, yy, yz, zz = (float(inertia.get(name, 0.0)) for name in INERTIA)
    matrix = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    if np.linalg.eigvalsh(matrix).min() <= 0.0:
        link.remove(inertial)


def _add_compiler_options(root: Element) -> None:
    """Tell MuJoCo how to read the description."""
    options = ElementTree.SubElement(root, "mujoco")
    ElementTree.SubElement(
        options,
        "compiler",
        fusestatic="false",  # every link stays a body
        discardvisual="false",
        boundmass="0.001",  # for links without a mass
        boundinertia="1e-6",
        balanceinertia="true",
    )
