"""Reads the triangles of a mesh, in bounded memory."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aicon_torch.errors import OptionError, choices
from aicon_torch.extras import import_extra
from aicon_torch.parts.descriptions.attributes import LARGEST_NUMBER
from aicon_torch.parts.descriptions.collada import count_nodes
from aicon_torch.parts.descriptions.files import LARGEST_MESH, check_file

FORMATS = (".stl", ".dae", ".obj", ".ply", ".off", ".glb")
"""The endings that are read. Archives are not: unpacked, one may have any size."""

MOST_TRIANGLES = 1_000_000
"""Of one mesh."""

MOST_NODES = 100_000
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
        nodes = count_nodes(path) if path.suffix.lower() == ".dae" else 1
        if nodes > MOST_NODES:
            raise OptionError(
                f"{called}: its scene has {nodes:.0f} nodes, expected at most {MOST_NODES:,}."
            )

        with np.errstate(all="ignore"):  # what is not finite is looked for afterwards
            mesh = trimesh.load_mesh(path)
        if mesh.units is not None:
            mesh.convert_units("meters")
    except (ImportError, OptionError):
        raise
    except Exception as error:  # each format's reader raises others
        raise OptionError(f"{called} cannot be read ({type(error).__name__}: {error}).") from error
    return mesh


def _is_line(points: NDArray[Any]) -> bool:
    """Whether points ``(N, 3)`` all lie on one line, or are one point."""
    offsets = points - points[0]
    sizes = np.linalg.svd(offsets.T @ offsets, compute_uv=False)  # extents, squared
    return bool(sizes[1] <= FLAT**2 * sizes[0])
