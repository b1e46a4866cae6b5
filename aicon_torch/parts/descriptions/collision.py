"""Reads the collision geometry of a URDF, in m and in the frames of its links."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from aicon_torch.errors import OptionError
from aicon_torch.extras import import_extra
from aicon_torch.parts.descriptions.urdf import origin_of, parse_xml


class Cylinder(NamedTuple):
    """A segment along z with a radius; round at its ends or flat.

    Attributes:
        pose: ``(4, 4)``, its middle in the frame of the link.
        length: Of the segment, m.
        radius: m.
        is_round: Whether it is a capsule; of length zero, a sphere.
    """

    pose: NDArray[Any]
    length: float
    radius: float
    is_round: bool


@dataclass
class CollisionGeometry:
    """What one link consists of.

    Attributes:
        cylinders: Cylinders, capsules and spheres.
        triangles: The surfaces of boxes and meshes, ``(triangles, 3, 3)`` each.
    """

    cylinders: list[Cylinder] = field(default_factory=list)
    triangles: list[NDArray[Any]] = field(default_factory=list)


def read_collision_geometry(source: str | Path) -> dict[str, CollisionGeometry]:
    """The collision geometry of the links that have one, by their names.

    Args:
        source: A file, or the text of one that names meshes by their whole paths.

    Raises:
        FileNotFoundError: If there is no such file, or one of its meshes is not found.
        ModuleNotFoundError: If trimesh is missing.
        OptionError: If it is no URDF, or has a shape that URDF does not know.
    """
    root = parse_xml(source, root_tag="robot")
    is_text = isinstance(source, str) and source.lstrip().startswith("<")
    folder = Path() if is_text else Path(source).resolve().parent

    found: dict[str, CollisionGeometry] = {}
    for link in root.findall("link"):
        geometry = CollisionGeometry()
        for collision in link.findall("collision"):
            _add_shape(geometry, collision, folder)

        if geometry.cylinders or geometry.triangles:
            found[str(link.get("name"))] = geometry

    return found


def _add_shape(geometry: CollisionGeometry, collision: ElementTree.Element, folder: Path) -> None:
    """Add one `<collision>`."""
    pose = origin_of(collision)
    shape = collision.find("geometry/*")
    if shape is None:
        return

    if shape.tag in ("cylinder", "capsule", "sphere"):
        length, radius = float(shape.get("length", 0.0)), float(shape.get("radius", 0.0))
        geometry.cylinders.append(Cylinder(pose, length, radius, shape.tag != "cylinder"))
        return

    trimesh = import_extra("trimesh", "robots")
    if shape.tag == "box":
        mesh = trimesh.creation.box(extents=_vector(shape, "size"))
    elif shape.tag == "mesh":
        mesh = _load_mesh(trimesh, find_mesh(str(shape.get("filename")), folder))
        mesh.apply_scale(_vector(shape, "scale"))
    else:
        raise OptionError(
            f"<{shape.tag}> is no shape: expected box, capsule, cylinder, mesh or sphere."
        )

    mesh.apply_transform(pose)
    geometry.triangles.append(np.array(mesh.triangles))


def find_mesh(filename: str, folder: Path) -> Path:
    """The file of a mesh.

    Args:
        filename: As in the URDF: a path, absolute or from the URDF's folder, or
            ``package://package/path``, where the package is looked for in the folders above.
        folder: That of the URDF.

    Raises:
        FileNotFoundError: If it is not there.
    """
    scheme, _, path = filename.rpartition("://")
    candidates = [folder / path] if scheme != "file" else [Path(path)]
    if scheme in ("package", "model"):
        _, _, inside = path.partition("/")
        for above in (folder, *folder.parents):
            candidates += [above / path, above / inside]

    for candidate in candidates:
        if candidate.is_file():
            return candidate
    raise FileNotFoundError(f"The mesh {filename} is neither in {folder} nor in a folder above it.")


def _load_mesh(trimesh: Any, path: Path) -> Any:
    """The mesh of a file, in m where the file names its unit."""
    mesh = trimesh.load_mesh(path)
    if mesh.units is not None:
        mesh.convert_units("meters")
    return mesh


def _vector(shape: ElementTree.Element, attribute: str) -> NDArray[Any]:
    """Three numbers; ones where the file has none."""
    return np.array([float(number) for number in shape.get(attribute, "1 1 1").split()])
