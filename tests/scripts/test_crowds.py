"""The studies of where projection matters: retargeting and the doorway, cut short."""

import numpy as np

import doorway
import doorway_world
import retarget
import retarget_world


def test_points_of_an_arm_are_held_by_a_projection_and_not_by_a_sum() -> None:
    """Four points against a wall of slope 2: 4 > 2 > 1.1."""
    joints, points = retarget_world.references(4, 2, seconds=4.0, seed=1000)
    deepest = points[..., 0].max(-1)
    walls = np.quantile(deepest, 0.6, axis=0)[:, None]

    behind = {}
    for rule in ("sum", "projection"):
        policy = retarget_world.make_policy(retarget.rules()[rule], 4)
        depths, errors, _ = retarget_world.follow(
            policy, joints, points, walls, np.full((2, 1), 2.0)
        )
        assert errors[0].max() < 0.01  # it begins where the reference does
        behind[rule] = depths[50:].max()
    assert behind["projection"] < retarget.BEHIND < behind["sum"]


def test_discs_that_do_not_explore_never_touch() -> None:
    discs, targets = doorway_world.starts(2, 2, seed=1000)
    path = doorway_world.drive(doorway.rules()["projection"], discs, targets, steps=60)
    assert np.linalg.norm(path[:, :, 0] - path[:, :, 1], axis=-1).min() > 2 * doorway_world.RADIUS
    assert (
        np.linalg.norm(np.diff(path, axis=0), axis=-1).max()
        <= 1.001 * doorway_world.SPEED * doorway_world.DT
    )
