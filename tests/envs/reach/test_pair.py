"""Two arms that face each other across a table."""

import numpy as np
import pytest

pytest.importorskip("mujoco")
pytest.importorskip("trimesh")

from aicon_envs.reach import ROBOTS
from aicon_envs.reach.pair import ArmPair

UR5 = ROBOTS["ur5"]
HOME = np.array(UR5.home)
AT_REST = np.zeros(6)


@pytest.fixture(scope="module")
def pair() -> ArmPair:
    return ArmPair(UR5, UR5, distance=1.0)


def test_two_that_do_the_same_mirror_each_other(pair: ArmPair) -> None:
    pair.start((HOME, HOME))
    for _ in range(20):
        pair.step((np.full(6, 0.2), np.full(6, 0.2)))
    first, second = pair.joints
    np.testing.assert_allclose(first, second, atol=1e-6)
    np.testing.assert_allclose(first, HOME + 0.08, atol=0.01)


def test_arms_that_reach_into_each_other_touch(pair: ArmPair) -> None:
    """Both come from above the middle down to it, where there is room for one."""
    ahead = HOME + np.array([0.0, 0.5, -0.6, 0.1, 0.0, 0.0])
    pair.start((HOME, HOME))
    assert min(pair.gaps) > 0.0
    for _ in range(100):
        first, second = (np.clip(ahead - joints, -0.5, 0.5) for joints in pair.joints)
        pair.step((first, second))
    assert pair.gaps.apart < 0.0
    assert pair.gaps.to_itself > 0.0


def test_an_arm_that_goes_down_touches_the_table_and_not_the_other(pair: ArmPair) -> None:
    pair.start((HOME, HOME))
    for _ in range(150):
        pair.step((np.array([0.0, 0.5, 0.3, 0.0, 0.0, 0.0]), AT_REST))
    assert pair.gaps.to_table < 0.0
