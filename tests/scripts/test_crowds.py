"""The studies of where projection matters: retargeting and the doorway, cut short."""

import numpy as np
import pytest
from _inputs import quick

import doorway
import doorway_world
import retarget
import retarget_film
import retarget_world
from rule_study import RULES


@pytest.mark.slow
def test_points_of_an_arm_are_held_by_a_projection_and_not_by_a_sum() -> None:
    """Four points against a wall of slope 2: 4 > 2 > 1.1."""
    joints, points = retarget_world.references(4, 2, seconds=4.0, seed=1000)
    deepest = points[..., 0].max(-1)
    walls = np.quantile(deepest, 0.6, axis=0)[:, None]

    behind = {}
    for rule in ("sum", "projection"):
        policy = quick(retarget_world.make_policy(RULES[rule], 4))
        depths, errors, _ = retarget_world.follow(
            policy, joints, points, walls, np.full((2, 1), 2.0)
        )
        assert errors[0].max() < 0.01  # it begins where the reference does
        behind[rule] = depths[50:].max()
    assert behind["projection"] < retarget.BEHIND < behind["sum"]


def test_discs_that_do_not_explore_never_touch() -> None:
    discs, targets = doorway_world.starts(2, 2, seed=1000)
    path = doorway_world.drive(doorway.RULES["projection"], discs, targets, steps=60)
    assert np.linalg.norm(path[:, :, 0] - path[:, :, 1], axis=-1).min() > 2 * doorway_world.RADIUS
    assert (
        np.linalg.norm(np.diff(path, axis=0), axis=-1).max()
        <= 1.001 * doorway_world.SPEED * doorway_world.DT
    )


def test_a_film_shows_an_arm_whose_points_are_behind_the_wall_in_red() -> None:
    still = np.tile(retarget_world.HOME, (2, 1))
    links, points = retarget_film.shape(still)
    assert links.shape == (2, 9, 2) and points.shape == (2, 8, 2)
    assert points[0, 0] == pytest.approx(links[0, -1])  # the first point is the tip
    farthest = float(points[0, :, 0].max())

    def reds(wall: float) -> int:
        (frame,) = retarget_film.draw(still, {"sum": still}, wall)
        return int(((frame[..., 0] > 150) & (frame[..., 1] < 60)).sum())

    assert reds(farthest + 0.1) == 0 < reds(farthest - 0.05)
