"""Mazes: every cell of a grid is reached from every other by exactly one way."""

import numpy as np
import shapely
from shapely.geometry import LineString

from aicon_envs.nav2d.maps.sketch import Sketch
from aicon_envs.nav2d.world import Point

Cell = tuple[int, int]


def maze(rng: np.random.Generator) -> Sketch:
    """A maze on 4×4 to 6×6 cells of about 1.2 m; start and target lie in cells at least the grid's side apart."""
    size, cell, thickness = int(rng.integers(4, 7)), rng.uniform(1.15, 1.25), rng.uniform(0.1, 0.15)
    passages = _spanning_tree(size, rng)
    lines = [LineString([(0, 0), (size, 0), (size, size), (0, size), (0, 0)])]
    for x in range(size):
        for y in range(size):
            if x + 1 < size and frozenset({(x, y), (x + 1, y)}) not in passages:
                lines.append(LineString([(x + 1, y), (x + 1, y + 1)]))
            if y + 1 < size and frozenset({(x, y), (x, y + 1)}) not in passages:
                lines.append(LineString([(x, y + 1), (x + 1, y + 1)]))
    metres = shapely.transform(shapely.union_all(lines), lambda grid: grid * cell)
    solid = metres.buffer(thickness / 2.0, cap_style="square", join_style="mitre")
    start, target = _distant_cells(size, rng)
    return Sketch(solid, _center(start, cell), _center(target, cell))


def _spanning_tree(size: int, rng: np.random.Generator) -> set[frozenset[Cell]]:
    """Return the passages (pairs of cells) that a random depth-first walk through the grid takes."""
    walk: list[Cell] = [(int(rng.integers(size)), int(rng.integers(size)))]
    visited = {walk[0]}
    passages: set[frozenset[Cell]] = set()
    while walk:
        x, y = walk[-1]
        near = [(x + 1, y), (x - 1, y), (x, y + 1), (x, y - 1)]
        fresh = [(i, j) for i, j in near if 0 <= i < size and 0 <= j < size and (i, j) not in visited]
        if not fresh:
            walk.pop()
            continue
        step = fresh[int(rng.integers(len(fresh)))]
        passages.add(frozenset({(x, y), step}))
        visited.add(step)
        walk.append(step)
    return passages


def _distant_cells(size: int, rng: np.random.Generator) -> tuple[Cell, Cell]:
    cells = [(x, y) for x in range(size) for y in range(size)]
    pairs = [(a, b) for a in cells for b in cells if np.hypot(a[0] - b[0], a[1] - b[1]) >= size]
    return pairs[int(rng.integers(len(pairs)))]


def _center(cell: Cell, side: float) -> Point:
    return (cell[0] + 0.5) * side, (cell[1] + 0.5) * side
