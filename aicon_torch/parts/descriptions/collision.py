"""Reads the collision geometry of a URDF, in m and in the frames of its links."""

import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from aicon_torch.errors import OptionError
from aicon_torch.extras import import_extra
from aicon_torch.parts.descriptions.attributes import numbers_of, positive_of, text_of
from aicon_torch.parts.descriptions.files import is_text
from aicon_torch.parts.descriptions.meshes import MOST_TRIANGLES, read_triangles
from aicon_torch.parts.descriptions.urdf import origin_of, parse_xml

MOST_SHAPES = 300
"""Of one robot; the most in example-robot-data is 112."""


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

    @property
    def count(self) -> int:
        """The number of triangles."""
        return sum(map(len, self.triangles))


def read_collision_geometry(source: str | Path) -> dict[str, CollisionGeometry]:
    """The collision geometry of the links that have one, by their names.

    Args:
        source: A file, or the text of one that names meshes by their whole paths.

    Raises:
        FileNotFoundError: If there is no such file, or one of its meshes is not found.
        ModuleNotFoundError: If trimesh is missing.
        OptionError: If it is no URDF, has a shape that URDF does not know, or a shape or mesh is
            not what it may be; it names the link and its element.
    """
    root = parse_xml(source, root_tag="robot")
    folder = Path() if is_text(source) else Path(source).resolve().parent

    # Counted before anything is read, since all that follows takes time and memory.
    count = len(root.findall("link/collision"))
    if count > MOST_SHAPES:
        raise OptionError(
            f"The robot has {count} shapes that collide: expected at most {MOST_SHAPES}."
        )

    found: dict[str, CollisionGeometry] = {}
    triangles = 0
    for link in root.findall("link"):
        name = text_of(link, "name", "A link")
        geometry = CollisionGeometry()
        for collision in link.findall("collision"):
            _add_shape(geometry, collision, folder, f"Link {name!r}")
            if triangles + geometry.count > MOST_TRIANGLES:
                raise OptionError(
                    f"The meshes of the robot have more than {MOST_TRIANGLES:,} triangles, up to "
                    f"those of link {name!r}: expected coarser ones."
                )

        triangles += geometry.count
        if geometry.cylinders or geometry.triangles:
            found[name] = geometry

    return found


def _add_shape(
    geometry: CollisionGeometry, collision: ElementTree.Element, folder: Path, owner: str
) -> None:
    """Add one `<collision>` of a link."""
    pose = origin_of(collision, owner)
    shape = collision.find("geometry/*")
    if shape is None:
        return

    if shape.tag == "sphere":
        radius = positive_of(shape, "radius", owner)
        geometry.cylinders.append(Cylinder(pose, 0.0, radius, is_round=True))
    elif shape.tag in ("cylinder", "capsule"):
        length, radius = (positive_of(shape, name, owner) for name in ("length", "radius"))
        geometry.cylinders.append(Cylinder(pose, length, radius, shape.tag == "capsule"))
    elif shape.tag == "box":
        geometry.triangles.append(_moved(_box(shape, owner), pose))
    elif shape.tag == "mesh":
        geometry.triangles.append(_moved(_mesh(shape, folder, owner), pose))
    else:
        raise OptionError(
            f"{owner}: <{shape.tag}> is no shape; expected box, capsule, cylinder, mesh or sphere."
        )


def _box(shape: ElementTree.Element, owner: str) -> NDArray[Any]:
    """The surface of a box about the origin, ``(12, 3, 3)``, m."""
    size = numbers_of(shape, "size", owner)
    if (size <= 0.0).any():
        raise OptionError(f"{owner}: <box size={shape.get('size')!r}>: expected 3 numbers above 0.")

    trimesh = import_extra("trimesh", "robots")
    return np.array(trimesh.creation.box(extents=size).triangles)


def _mesh(shape: ElementTree.Element, folder: Path, owner: str) -> NDArray[Any]:
    """The surface of a mesh in its size, ``(triangles, 3, 3)``, m."""
    file = find_mesh(text_of(shape, "filename", owner), folder)
    scale = numbers_of(shape, "scale", owner, (1.0, 1.0, 1.0))
    if (scale == 0.0).any():
        raise OptionError(
            f"{owner}: <mesh scale={shape.get('scale')!r}>: expected 3 numbers other than 0."
        )
    return np.asarray(scale * read_triangles(file, owner))


def _moved(triangles: NDArray[Any], pose: NDArray[Any]) -> NDArray[Any]:
    """Triangles ``(T, 3, 3)`` after a rigid motion ``(4, 4)``."""
    return np.asarray(triangles @ pose[:3, :3].T + pose[:3, 3])


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

    # From the folder of the URDF, unless it is a whole path.
    candidates = [folder / path] if scheme != "file" else [Path(path)]
    if scheme in ("package", "model"):
        # A folder above holds the package, or is the package under another name.
        _, _, inside = path.partition("/")
        for above in (folder, *folder.parents):
            candidates += [above / path, above / inside]

    for candidate in candidates:
        if os.path.isfile(candidate):  # pathlib's own may raise
            return candidate
    raise FileNotFoundError(f"The mesh {filename} is neither in {folder} nor in a folder above it.")
