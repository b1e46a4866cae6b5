"""Problems of others: how their objects are placed, and what is said without a network."""

from pathlib import Path

import numpy as np
import pytest
import torch

from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.worlds import motion_bench_maker
from aicon_torch.parts import Chain
from aicon_torch.parts.solids import distance_of_point

QUARTER = 0.5**0.5
TURNED = {
    "id": "shelf",
    "pose": {"position": [1.0, 0.0, 0.0], "orientation": [0.0, 0.0, QUARTER, QUARTER]},
    "primitives": [{"type": "box", "dimensions": [0.6, 0.2, 0.2]}],
    "primitive_poses": [
        {"position": [0.5, 0.0, 0.0], "orientation": [0.0, QUARTER, 0.0, QUARTER]},
    ],
}
"""0.6 m along z, after a quarter turn about y, half a metre along y from (1, 0, 0)."""


def test_an_object_is_placed_in_a_frame_of_its_own() -> None:
    numbers = motion_bench_maker._solid(TURNED, np.zeros(3)).numbers()
    points = torch.tensor([[1.0, 0.5, 0.4], [1.2, 0.5, 0.0], [1.0, 0.7, 0.0]]).double()
    expected = torch.tensor([0.1, 0.1, 0.1]).double()
    torch.testing.assert_close(distance_of_point(points, numbers), expected)


def test_an_object_without_a_frame_is_placed_in_that_of_the_base() -> None:
    placed = {key: value for key, value in TURNED.items() if key != "pose"}
    numbers = motion_bench_maker._solid(placed, np.array([0.0, 0.0, 0.4])).numbers()
    torch.testing.assert_close(numbers[:3], torch.tensor([0.5, 0.0, -0.4]).double())


def test_without_a_network_it_says_where_to_put_the_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(motion_bench_maker, "_index", lambda: "http://127.0.0.1:9/simple")
    with pytest.raises(ComparisonError, match=r"Where there is no network, put vamp_planner"):
        motion_bench_maker.resources(tmp_path)


LIFT = """
<robot name="lift">
  <link name="base"/><link name="torso"/>
  <joint name="lift" type="prismatic">
    <parent link="base"/><child link="torso"/><origin xyz="0.1 0 0.4"/><axis xyz="0 0 1"/>
    <limit lower="0" upper="0.4" velocity="0.1" effort="1"/>
  </joint>
</robot>
"""


def test_an_arm_stands_where_its_torso_is_at_the_goal() -> None:
    held = Chain.from_urdf(LIFT, "torso")
    place = motion_bench_maker._place_of_base(held, {"lift": 0.3, "elbow": 1.0})
    np.testing.assert_allclose(place, [0.1, 0.0, 0.7])


TWO_JOINTS = """
<robot name="arm">
  <link name="base"/><link name="upper"/><link name="lower"/>
  <joint name="shoulder" type="revolute">
    <parent link="base"/><child link="upper"/>
    <origin xyz="0 0 0.3" rpy="0.3 -0.2 0.5"/><axis xyz="0 1 0"/>
    <limit lower="-2" upper="2" velocity="1" effort="1"/>
  </joint>
  <joint name="elbow" type="revolute">
    <parent link="upper"/><child link="lower"/><origin xyz="0.4 0 0"/><axis xyz="0 0 1"/>
    <limit lower="-2" upper="2" velocity="1" effort="1"/>
  </joint>
</robot>
"""


def test_a_joint_that_is_held_leaves_the_arm_as_it_was_there() -> None:
    held = Chain.from_urdf(motion_bench_maker._with_joints_held(TWO_JOINTS, {"shoulder": 0.7}))
    assert held.names == ("elbow",)
    whole = Chain.from_urdf(TWO_JOINTS)
    place = whole(torch.tensor([0.7, -0.4], dtype=torch.float64))
    torch.testing.assert_close(held(torch.tensor([-0.4], dtype=torch.float64)), place)
