"""Capsules that were fitted before, in this process or an earlier one of this user's."""

import hashlib
import inspect
import json
from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aicon_torch.parts import capsule_fit
from aicon_torch.parts.capsule_fit import Segment, around_surfaces
from aicon_torch.user_cache import cache_folder, keep, read_kept

_FITTED: dict[str, list[Segment]] = {}
"""Those of this process."""


def fitted_once(surfaces: Sequence[NDArray[Any]], count: int) -> list[Segment]:
    """A few capsules about some surfaces: see :func:`around_surfaces`.

    A link takes about a second, and a robot is read again by every policy, shield and world, and by
    every process. What was fitted is kept in the user's cache under a name that follows from the
    surfaces and from the code that fits; it is taken only if nobody else may have written it and
    its checksum is right.

    Args:
        surfaces: ``(T, 3, 3)`` each, triangles, m.
        count: At most so many capsules.
    """
    name = _name(surfaces, count)
    if name not in _FITTED:
        _FITTED[name] = _read_or_fit(name, surfaces, count)
    return _FITTED[name]


def _name(surfaces: Sequence[NDArray[Any]], count: int) -> str:
    """A hash of what is fitted and how."""
    digest = hashlib.sha256(f"{count} {len(surfaces)} {_code()}".encode())
    for surface in surfaces:
        digest.update(str(surface.shape).encode())
        digest.update(surface.tobytes())
    return digest.hexdigest()[:32]


@cache
def _code() -> str | None:
    """The code that fits; None where programs are without their sources."""
    try:
        return inspect.getsource(capsule_fit)
    except OSError:
        return None


def _read_or_fit(name: str, surfaces: Sequence[NDArray[Any]], count: int) -> list[Segment]:
    """The capsules that an earlier process has kept, or new ones, which are kept."""
    folder = cache_folder()
    if folder is None or _code() is None:
        return around_surfaces(surfaces, count)

    path = folder / f"{name}.capsules"
    content = read_kept(path)
    segments = None if content is None else _from_bytes(content)
    if segments is None:
        segments = around_surfaces(surfaces, count)
        keep(path, _to_bytes(segments))
    return segments


def _to_bytes(segments: Sequence[Segment]) -> bytes:
    """A line with the checksum of what follows: both ends and the radius of each, in JSON."""
    rows = [[*start.tolist(), *end.tolist(), radius] for start, end, radius in segments]
    text = json.dumps(rows).encode()
    return hashlib.sha256(text).hexdigest().encode() + b"\n" + text


def _from_bytes(content: bytes) -> list[Segment] | None:
    """The capsules; None if this is not what was written."""
    checksum, _, text = content.partition(b"\n")
    if hashlib.sha256(text).hexdigest().encode() != checksum:
        return None
    rows = json.loads(text)
    return [Segment(np.array(row[:3]), np.array(row[3:6]), row[6]) for row in rows]
