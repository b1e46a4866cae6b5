"""How an arm sees the one that faces it."""

import numpy as np
import pytest

pytest.importorskip("mujoco")
pytest.importorskip("trimesh")

import torch

from aicon_torch.parts.solids import distance_of_point
from two_arms import DISTANCE, Arm, turn_of_z


@pytest.mark.parametrize("way", [(0.3, -0.2, 0.5), (0.0, 0.0, -2.0), (0.0, 0.0, 0.1)])
def test_the_z_axis_is_turned_into_a_way(way: tuple[float, float, float]) -> None:
    turn, direction = turn_of_z(np.array(way)), np.array(way) / np.linalg.norm(way)
    np.testing.assert_allclose(turn[:, 2], direction, atol=1e-12)
    np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(turn) > 0


def test_points_of_an_arm_are_as_deep_in_its_capsules_for_the_other_one() -> None:
    """The distance of each capsule's middle from itself is its radius, below 0."""
    arm = Arm("ur5")
    q = arm.home
    seen = torch.from_numpy(arm.seen_by_the_other(q)).reshape(-1, 16)
    ends = arm.segments(torch.from_numpy(q)).reshape(-1, 2, 3)
    facing = torch.tensor([-1.0, -1.0, 1.0], dtype=torch.float64)
    middles = facing * ends.mean(-2) + facing.new_tensor([DISTANCE, 0.0, 0.0])
    radii = torch.from_numpy(arm.radii).squeeze(-1)
    torch.testing.assert_close(distance_of_point(middles, seen), -radii)
