"""The planner that mazes are compared with."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

MAZE = ["########", "#      #", "# #### #", "# #    #", "# # ## #", "#   #  #", "########"]
RADIUS, STRIDE = 0.2, 0.05


@pytest.fixture
def planner(world_of: Callable[[str], Any]) -> Any:
    """A planner whose actions are steps of a given length."""

    def step(place: Any, seen: Any) -> Any:
        way = place - seen["z_ball"]
        return way * min(1.0, STRIDE / max(float(np.linalg.norm(way)), STRIDE))

    grid = [[int(cell == "#") for cell in row] for row in MAZE]
    return world_of("planner").Planner(grid, RADIUS, step)


def free_cells(planner: Any) -> Any:
    """Those that no wall is in."""
    return [tuple(map(int, cell)) for cell in np.argwhere(~planner.is_wall)]


def test_a_way_is_as_long_as_the_cells_are_apart(planner: Any) -> None:
    assert len(planner.way((5, 3), (5, 5))) == 9  # up, around two walls, and down again

    end = (1, 1)
    for cell in free_cells(planner):
        way = planner.way(cell, end)
        steps = np.abs(np.diff(way, axis=0)).sum(-1) if len(way) > 1 else np.ones(0)
        assert way[-1] == end and (steps == 1).all()
        assert len(way) - 1 == planner.distances_to(end)[cell]


def test_a_ball_comes_from_anywhere_to_anywhere_and_touches_no_wall(planner: Any) -> None:
    starts, ends = free_cells(planner)[::3], free_cells(planner)[::4]
    balls = planner.places_of([start for start in starts for _ in ends])
    goals = planner.places_of([end for _ in starts for end in ends])

    for _ in range(round(20 / STRIDE)):
        moves, _ = planner.predict({"z_ball": balls, "z_goal": goals})
        for ball, move in zip(balls, moves, strict=True):
            assert planner.is_free(ball, ball + move)
        balls = balls + moves
        if not moves.any():  # all have arrived
            break
    assert np.linalg.norm(balls - goals, axis=-1).max() < 1e-9


def test_a_goal_in_a_wall_has_a_way_too(planner: Any) -> None:
    way = planner.way((1, 1), (2, 2))
    assert way[-1] == (2, 2) and len(way) == 3
