"""Maps of rooms and passages: halls with doors, and mazes.

In a maze every cell of a grid is reached from every other by exactly one way.
"""

import math
from itertools import product

import numpy as np
import shapely
from shapely.geometry import LineString, box
from shapely.geometry.base import BaseGeometry

from aicon_envs.nav2d.maps.layout import Layout, draw_thickness, wall
from aicon_envs.nav2d.world import Point

Cell = tuple[int, int]
"""Column and row of a cell of the grid."""

Passages = set[frozenset[Cell]]
"""Pairs of neighbouring cells without a wall between them."""


def corridors(rng: np.random.Generator) -> Layout:
    """A hall divided by walls across it, each with one door."""
    rooms = int(rng.integers(4, 7))
    height = rng.uniform(2.5, 4.0)
    thickness = draw_thickness(rng)
    widths = rng.uniform(1.2, 1.7, size=rooms)
    borders = np.concatenate([[0.0], np.cumsum(widths)])

    # Each wall across leaves a door at a random height.
    walls = [_hall(borders[-1], height, thickness)]
    for x in borders[1:-1]:
        door = rng.uniform(0.8, 1.2)
        low = rng.uniform(0.0, height - door - thickness) + thickness / 2.0
        walls.append(wall([(x, 0.0), (x, low)], thickness))
        walls.append(wall([(x, low + door), (x, height)], thickness))

    # Start in the first room, target in the last.
    middles = (borders[:-1] + borders[1:]) / 2.0
    start = (float(middles[0]), rng.uniform(0.55, height - 0.55))
    target = (float(middles[-1]), rng.uniform(0.55, height - 0.55))
    return Layout(shapely.union_all(walls), start, target)


def maze(rng: np.random.Generator) -> Layout:
    """A maze on 4×4 to 6×6 cells of about 1.2 m; the ends are at least the grid's side apart."""
    size = int(rng.integers(4, 7))
    cell_side = rng.uniform(1.15, 1.25)
    thickness = rng.uniform(0.1, 0.15)

    # A wall between two cells unless a passage joins them.
    passages = _draw_spanning_tree(size, rng)
    lines = shapely.union_all(_wall_lines(size, passages))
    lines = shapely.transform(lines, lambda cells: cells * cell_side)
    solid = lines.buffer(thickness / 2.0, cap_style="square", join_style="mitre")

    start, target = _draw_distant_cells(size, rng)
    return Layout(solid, _center(start, cell_side), _center(target, cell_side))


def _hall(length: float, height: float, thickness: float) -> BaseGeometry:
    """Return the outer wall of a hall, whose middle line is the rectangle length × height."""
    rectangle = box(0.0, 0.0, length, height)
    outside = rectangle.buffer(thickness / 2.0, join_style="mitre")
    inside = rectangle.buffer(-thickness / 2.0, join_style="mitre")
    return outside - inside


def _wall_lines(size: int, passages: Passages) -> list[LineString]:
    """Return the middle lines of a maze's walls, in cells: the border, and where no passage is."""
    lines = [LineString([(0, 0), (size, 0), (size, size), (0, size), (0, 0)])]

    for x, y in product(range(size), repeat=2):
        right, above = (x + 1, y), (x, y + 1)
        corner = (x + 1, y + 1)

        # The border is there already, so the last column and row add nothing outside.
        if x + 1 < size and frozenset({(x, y), right}) not in passages:
            lines.append(LineString([right, corner]))
        if y + 1 < size and frozenset({(x, y), above}) not in passages:
            lines.append(LineString([above, corner]))

    return lines


def _draw_spanning_tree(size: int, rng: np.random.Generator) -> Passages:
    """Return the passages that a random depth-first walk through the grid takes."""
    first = (int(rng.integers(size)), int(rng.integers(size)))
    walk: list[Cell] = [first]
    visited: set[Cell] = {first}
    passages: Passages = set()

    while walk:
        cell = walk[-1]
        unvisited = _unvisited_neighbours(cell, size, visited)
        if not unvisited:
            walk.pop()  # a dead end: one step back
            continue

        following = unvisited[int(rng.integers(len(unvisited)))]
        passages.add(frozenset({cell, following}))
        visited.add(following)
        walk.append(following)

    return passages


def _unvisited_neighbours(cell: Cell, size: int, visited: set[Cell]) -> list[Cell]:
    x, y = cell
    unvisited = []

    for column, row in ((x + 1, y), (x - 1, y), (x, y + 1), (x, y - 1)):
        in_grid = 0 <= column < size and 0 <= row < size
        if in_grid and (column, row) not in visited:
            unvisited.append((column, row))

    return unvisited


def _draw_distant_cells(size: int, rng: np.random.Generator) -> tuple[Cell, Cell]:
    """Draw one of the pairs of cells that are at least `size` cells apart."""
    cells = [(column, row) for column in range(size) for row in range(size)]

    # Both orders of each pair: a maze has no preferred direction.
    pairs = []
    for first, second in product(cells, repeat=2):
        if math.dist(first, second) >= size:
            pairs.append((first, second))

    return pairs[int(rng.integers(len(pairs)))]


def _center(cell: Cell, side: float) -> Point:
    """Return the middle of a cell, m."""
    column, row = cell
    return (column + 0.5) * side, (row + 0.5) * side
