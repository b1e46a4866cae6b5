"""Walls that a map tells: how far a robot in the plane is from each of their faces."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby

import torch
from torch import Tensor

from aicon_torch.errors import OptionError
from aicon_torch.parts.contact import likelihood_across
from aicon_torch.parts.planar import cross
from aicon_torch.validation import check_not_negative, check_positive

Face = tuple[float, float, float, float]
"""A straight piece of a wall's outline, from (x, y) to (x, y), m; what is free lies on its left."""


@dataclass(frozen=True)
class Walls:
    """The faces of walls, and the cost of coming near them.

    Every face has a gap of its own, so that in a corner both walls count.

    Attributes:
        faces: The faces.
        radius: Radius of the robot, m.
        thickness: Of a wall at least, m: within half of it behind a face, gaps are negative.

    Raises:
        OptionError: If there is no face, a face is a point, or a length is negative.

    Example:
        >>> walls = Walls.from_grid(["#####", "#   #", "### #", "#   #", "#####"], radius=0.1)
        >>> Goal("avoid", Interconnection(walls.collision_likelihood(0.04), ["p_robot"]))
    """

    faces: tuple[Face, ...]
    radius: float = 0.0
    thickness: float = 0.0

    def __post_init__(self) -> None:
        """Check faces and lengths."""
        check_not_negative(self, ("radius", "thickness"))
        try:
            faces = tuple(tuple(map(float, face)) for face in self.faces)
        except (TypeError, ValueError):  # no numbers
            faces = ()
        if not faces or any(len(face) != 4 for face in faces):
            raise OptionError(f"faces={self.faces!r}: expected one or more (x, y, x, y), m.")
        object.__setattr__(self, "faces", faces)
        for face in faces:
            if not all(map(math.isfinite, face)) or face[:2] == face[2:]:
                raise OptionError(f"faces: {face!r}: expected two points apart, (x, y, x, y), m.")

    @classmethod
    def from_grid(cls, rows: Sequence[str], cell: float = 1.0, radius: float = 0.0) -> "Walls":
        """The walls of a map in characters, whose middle is the origin.

        Args:
            rows: The map from above, north (+y) first; "#" is a wall, anything else is free.
            cell: Length of a cell, m.
            radius: Radius of the robot, m.

        Raises:
            OptionError: If the rows are not of one length, or hold no wall that borders on a cell.
        """
        if len({len(row) for row in rows}) != 1:
            raise OptionError(f"rows={rows!r}: expected strings of one length.")

        # Along a row a face is where wall and free lie above each other, along a column beside.
        height, width = len(rows), len(rows[0])
        across = [_borders(rows[i], rows[i + 1]) for i in range(height - 1)]
        columns = ["".join(column) for column in zip(*rows, strict=True)]
        along = [_borders(columns[j], columns[j + 1]) for j in range(width - 1)]

        faces: list[Face] = []
        for i, spans in enumerate(across):
            y = (height / 2 - i - 1) * cell
            for j, k, side in spans:
                # From west to east the north is on the left: turned round where the wall is there.
                ends = ((j - width / 2) * cell, y, (k - width / 2) * cell, y)
                faces.append(_turned(ends, side < 0))
        for j, spans in enumerate(along):
            x = (j + 1 - width / 2) * cell
            for i, k, side in spans:
                # From north to south the east is on the left.
                ends = (x, (height / 2 - i) * cell, x, (height / 2 - k) * cell)
                faces.append(_turned(ends, side > 0))
        return cls(tuple(faces), radius, cell)

    def gaps(self, position: Tensor) -> Tensor:
        """The gap between the robot at ``(*B, 2)`` and each of K faces, ``(*B, K)``, m."""
        faces = position.new_tensor(self.faces)
        start, end = faces[:, :2], faces[:, 2:]
        way, ahead = end - start, position.unsqueeze(-2) - start

        # In the axes of each face: how far along it from its start, and how far before it.
        length = torch.linalg.vector_norm(way, dim=-1)
        along = (ahead * way).sum(-1) / length
        before = cross(way, ahead) / length

        # How far it is beside the face's ends, and before it; less than 0 within the wall.
        beside = torch.maximum(-along, along - length).clamp(min=0.0)
        is_within = (beside == 0) & (before < 0) & (before > -self.thickness / 2)
        distance = torch.sqrt(before**2 + beside**2 + 1e-24)
        return torch.where(is_within, before, distance) - self.radius

    def collision_likelihood(self, length: float) -> "WallCost":
        """The cost Σ exp(−d/ℓ) over the gaps d, of a length ℓ, m, as a function of a position."""
        return WallCost(self, length)


@dataclass(frozen=True)
class WallCost:
    """Σ exp(−d/ℓ), ``(*B,)``, of a position ``(*B, 2)``: see :class:`Walls`.

    Attributes:
        walls: The walls.
        length: ℓ, m.

    Raises:
        OptionError: If the length is not positive.
    """

    walls: Walls
    length: float

    def __post_init__(self) -> None:
        """Check the length."""
        check_positive(self, ("length",))

    def __call__(self, position: Tensor) -> Tensor:
        """The cost."""
        return likelihood_across(self.walls.gaps(position), self.length).sum(-1)


def _turned(face: Face, keeps: bool) -> Face:
    return face if keeps else (*face[2:], *face[:2])


def _borders(first: str, second: str) -> list[tuple[int, int, int]]:
    """Where one of two lines of cells is a wall and the other is not: (begin, end, which)."""
    # 1 where the first is the wall, −1 where the second is, 0 where no face lies between them.
    sides = [(a == "#") - (b == "#") for a, b in zip(first, second, strict=True)]
    spans: list[tuple[int, int, int]] = []
    begin = 0
    for side, run in groupby(sides):
        end = begin + len(list(run))
        if side:
            spans.append((begin, end, side))
        begin = end
    return spans
