"""A planner that sees the map of a maze: a shortest way through its cells, and straight along it.

It is what mazes are compared with, and no part of AICON: it knows beforehand which way is open.
"""

from collections.abc import Callable
from typing import Any

import networkx  # it comes with torch
import numpy as np

TOUCHES = 1e-6  # by how much a ball beside a wall may be in it, cells

Array = Any


class Planner:
    """It goes to the farthest place of the shortest way that it sees.

    Args:
        grid: The maze, north first: 1 where a wall is; cells are 1 long, places from the middle.
        radius: Of the ball, cells.
        command: The action of a row, of where to and of what it observes.
    """

    def __init__(self, grid: Array, radius: float, command: Callable[[Array, Any], Array]) -> None:
        self.is_wall = np.array([[cell == 1 for cell in row] for row in grid])
        self.middle = (np.array(self.is_wall.shape) - 1) / 2
        self.walls = self.places_of(np.argwhere(self.is_wall))
        self.radius, self.command = radius, command
        self.cells = networkx.grid_2d_graph(*self.is_wall.shape)
        self.closed = set(map(tuple, np.argwhere(self.is_wall).tolist()))
        self.distances: dict[tuple[int, ...], dict[tuple[int, ...], int]] = {}

    def predict(self, observation: Any, state: Any = None, *_: Any, **__: Any) -> Any:
        """The actions of a batch; nothing is remembered."""
        actions = []
        for number in range(len(observation["z_ball"])):
            row = {name: value[number] for name, value in observation.items()}
            actions.append(self.command(self.target(row["z_ball"], row["z_goal"]), row))
        return np.array(actions), state

    def target(self, ball: Array, goal: Array) -> Array:
        """Where to go: the goal, or the farthest cell on the way that a straight line reaches."""
        way = self.way(self.cell_of(ball), self.cell_of(goal))
        places = [*self.places_of(way), goal]
        for place in reversed(places):
            if self.is_free(ball, place):
                return place
        return places[0]  # the middle of its own cell

    def way(self, start: tuple[int, ...], end: tuple[int, ...]) -> list[tuple[int, ...]]:
        """The cells of a shortest way."""
        distances, way = self.distances_to(end), [start]
        while way[-1] != end:
            neighbours = [cell for cell in _beside(way[-1]) if cell in distances]
            if not neighbours:
                return way
            way.append(min(neighbours, key=distances.__getitem__))
        return way

    def distances_to(self, end: tuple[int, ...]) -> dict[tuple[int, ...], int]:
        """How many cells those that lead to one are from it."""
        if end not in self.distances:
            free = networkx.restricted_view(self.cells, self.closed - {end}, ())
            self.distances[end] = networkx.single_source_shortest_path_length(free, end)
        return self.distances[end]

    def is_free(self, start: Array, end: Array) -> bool:
        """Whether the ball gets straight from one place to another: no line enters a wider wall."""
        wide = 0.5 + self.radius - TOUCHES
        way = np.where(end == start, 1e-12, end - start)  # no division by zero

        # When it passes the two sides of a wall, along each axis, as shares of the way.
        passes = np.stack((self.walls - start - wide, self.walls - start + wide)) / way
        enters, leaves = passes.min(0).max(-1), passes.max(0).min(-1)
        return not ((enters < leaves) & (leaves > 0.0) & (enters < 1.0)).any()

    def cell_of(self, place: Array) -> tuple[int, ...]:
        """Row and column of a place."""
        south_east = np.array([-place[1], place[0]])
        return tuple(int(index) for index in np.rint(south_east + self.middle))

    def places_of(self, cells: Array) -> Array:
        """The middles of cells ``(..., 2)``."""
        south_east = np.asarray(cells) - self.middle
        return np.stack((south_east[..., 1], -south_east[..., 0]), axis=-1)


def _beside(cell: tuple[int, ...]) -> list[tuple[int, ...]]:
    """The four cells beside one; a maze has walls all around."""
    row, column = cell
    return [(row - 1, column), (row + 1, column), (row, column - 1), (row, column + 1)]
