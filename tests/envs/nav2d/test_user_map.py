"""Maps of the user's own: where start and target may be, and how many polygons."""

from typing import Any

import numpy as np
import pytest
from _nav2d_env import SQUARE, own_map

from aicon_envs.nav2d import Nav2DEnv
from aicon_envs.nav2d.boundaries import boundary_segments

FAR = [(5.0, 5.0), (6.0, 5.0), (6.0, 6.0)]


@pytest.mark.parametrize("target", [(1.5, 0.0), (1.0, 0.0), (2.0, 1.0)])
def test_a_target_inside_an_obstacle_is_refused(target: tuple[float, float]) -> None:
    message = r"target must be outside of every obstacle.*obstacles\[1\]"
    with pytest.raises(ValueError, match=message):
        Nav2DEnv().reset(options=own_map([FAR, SQUARE], target=target))


def test_a_target_beside_an_obstacle_is_accepted() -> None:
    _, info = Nav2DEnv().reset(options=own_map(target=(0.95, 0.0), start=(-1.0, 0.0)))
    assert info["map"] == "user"


def test_no_obstacles_are_a_map_too() -> None:
    _, info = Nav2DEnv(max_range=3.0).reset(options=own_map([]))
    assert info["clearance"] == 3.0


def test_of_many_polygons_the_broken_one_is_named() -> None:
    polygons: list[Any] = squares(50)
    polygons[31] = [(0, 0), (1, 1), (1, 0), (0, 1)]
    with pytest.raises(ValueError, match=r"obstacles\[31\] must be a simple polygon"):
        Nav2DEnv().reset(options=own_map(polygons, start=(-9, -9), target=(-8, -8)))


@pytest.mark.slow
def test_ten_thousand_polygons_have_the_clearance_of_the_nearest() -> None:
    polygons = squares(10_000)
    _, info = Nav2DEnv().reset(options=own_map(polygons, start=(1.5, 1.5), target=(-8, -8)))
    assert info["clearance"] == pytest.approx(np.hypot(0.5, 0.5) - 0.1)


@pytest.mark.parametrize("width", [1.0, 2.5])
def test_many_polygons_have_the_outline_of_few(width: float) -> None:
    """Apart, and overlapping: what is left of them does not depend on how the union is made."""
    polygons = squares(1_200, width)
    inside = polygons[:900]
    few, many = boundary_segments(inside), boundary_segments(polygons)

    # The outlines are compared where the further polygons do not reach.
    def below(segments: Any) -> set[tuple[float, ...]]:
        ends = np.concatenate([segments[0], segments[0] + segments[1]]).T
        return {tuple(map(float, sorted(end))) for end in ends if end[1::2].max() < 40.0}

    assert below(few) and below(few) == below(many)


def squares(count: int, width: float = 1.0) -> list[list[tuple[float, float]]]:
    """Squares on a grid of 2 m, row by row."""
    columns = 30
    polygons = []
    for index in range(count):
        x, y = 2.0 * (index % columns), 2.0 * (index // columns)
        polygons.append([(x, y), (x + width, y), (x + width, y + width), (x, y + width)])
    return polygons
