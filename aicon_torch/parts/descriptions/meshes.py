"""Reads the triangles of a mesh, in bounded memory."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aicon_torch.errors import OptionError, choices
from aicon_torch.extras import import_extra
from aicon_torch.parts.descriptions.attributes import LARGEST_NUMBER
from aicon_torch.parts.descriptions.collada import size_of_scene
from aicon_torch.parts.descriptions.files import LARGEST_MESH, check_file

FORMATS = (".stl", ".dae", ".obj", ".ply", ".off")
"""The endings that are read. Archives and glTF are not: unpacked, one may have any size."""

MOST_TRIANGLES = 1_000_000
"""Of one robot; the most in example-robot-data is 399,000."""

MOST_NODES = 1000
"""Of the scene of a Collada file, which may name one node many times."""

FLAT = 1e-9
"""A mesh whose points lie so near one line, in shares of its extent, encloses nothing."""


def read_triangles(path: Path, owner: str) -> NDArray[Any]:
    """The surface of a mesh, ``(triangles, 3, 3)``, in m where the file names its unit.

    Args:
        path: The file.
        owner: What an error calls the link that it belongs to.

    Raises:
        ModuleNotFoundError: If trimesh is missing, or what it needs for this format.
        OptionError: If it is of no format that is read, too large, broken, or no surface.
    """
    called = f"{owner}: the mesh {path}"
    if path.suffix.lower() not in FORMATS:
        raise OptionError(f"{called} has the ending {path.suffix!r}: expected {choices(FORMATS)}.")
    check_file(path, LARGEST_MESH)

    trimesh = import_extra("trimesh", "robots")
    triangles = np.array(_load(trimesh, path, called).triangles)
    if not 0 < len(triangles) <= MOST_TRIANGLES:
        raise OptionError(
            f"{called} has {len(triangles)} triangles: expected 1 to {MOST_TRIANGLES:,}."
        )
    if not (np.abs(triangles) <= LARGEST_NUMBER).all():
        raise OptionError(
            f"{called} has corners that are not finite, or beyond {LARGEST_NUMBER:.0e} m."
        )
    if _is_line(triangles.reshape(-1, 3)):
        raise OptionError(f"{called} has all of its corners on one line: expected a surface.")
    return triangles


def _load(trimesh: Any, path: Path, called: str) -> Any:
    """The mesh of a file; whatever its reader raises names the file."""
    try:
        if path.suffix.lower() == ".dae":
            _check_scene(path, called)

        with np.errstate(all="ignore"):  # what is not finite is looked for afterwards
            mesh = trimesh.load_mesh(path, process=False)  # and is not to be left out
        if mesh.units is not None:
            mesh.convert_units("meters")
    except (ImportError, OptionError):
        raise
    except Exception as error:  # each format's reader raises others
        raise OptionError(f"{called} cannot be read ({type(error).__name__}: {error}).") from error
    return mesh


def _check_scene(path: Path, called: str) -> None:
    """Check that a Collada file does not unfold to very much."""
    size = size_of_scene(path)
    for name, count, most in (
        ("nodes", size.nodes, MOST_NODES),
        ("triangles", size.triangles, MOST_TRIANGLES),
    ):
        if count > most:
            raise OptionError(
                f"{called}: its scene has {count:.0f} {name}, expected at most {most:,}."
            )


def _is_line(points: NDArray[Any]) -> bool:
    """Whether points ``(N, 3)`` all lie on one line, or are one point."""
    offsets = points - points[0]
    sizes = np.linalg.svd(offsets.T @ offsets, compute_uv=False)  # extents, squared
    return bool(sizes[1] <= FLAT**2 * sizes[0])
