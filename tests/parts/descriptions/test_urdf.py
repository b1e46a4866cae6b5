import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from aicon_torch.errors import OptionError
from aicon_torch.parts.descriptions import files, read_urdf

ARM = """<?xml version="1.0" encoding="utf-8"?>
<robot name="arm">
  <link name="base"/><link name="column"/><link name="hand"/>
  <joint name="lift" type="prismatic">
    <parent link="base"/><child link="column"/><axis xyz="0 0 2"/>
    <limit lower="0.1" upper="0.5" velocity="0.2" effort="1"/>
  </joint>
  <joint name="turn" type="continuous">
    <parent link="column"/><child link="hand"/>
    <origin xyz="0.1 0.2 0.3" rpy="0.4 -0.5 0.6"/>
    <limit velocity="3" effort="1"/>
  </joint>
</robot>"""


def test_limits_speeds_and_axes_are_those_of_the_file() -> None:
    lift, _ = read_urdf(ARM).path()
    assert (lift.low, lift.high, lift.speed) == (0.1, 0.5, 0.2)
    assert lift.axis.tolist() == [0.0, 0.0, 1.0]


def test_a_continuous_joint_has_no_ends_and_an_axis_is_x_by_default() -> None:
    _, turn = read_urdf(ARM).path()
    assert (turn.low, turn.high, turn.speed) == (-math.inf, math.inf, 3.0)
    assert turn.axis.tolist() == [1.0, 0.0, 0.0]


def test_an_origin_turns_about_x_then_y_then_z_of_the_parent() -> None:
    fixed = read_urdf(ARM).path()[1].fixed
    np.testing.assert_allclose(fixed[:3, 3], [0.1, 0.2, 0.3])

    # The angles of the rotation, read back.
    assert math.atan2(fixed[2, 1], fixed[2, 2]) == pytest.approx(0.4, abs=1e-15)
    assert -math.asin(fixed[2, 0]) == pytest.approx(-0.5, abs=1e-15)
    assert math.atan2(fixed[1, 0], fixed[0, 0]) == pytest.approx(0.6, abs=1e-15)


def test_a_file_is_read_as_its_text_is(tmp_path: Path) -> None:
    file = tmp_path / "arm.urdf"
    file.write_text(ARM)
    for source in (file, str(file)):
        assert [joint.name for joint in read_urdf(source).joints] == ["lift", "turn"]


XACRO = """
<robot name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:arm prefix="left_"/></robot>
"""


@pytest.mark.parametrize(
    ("source", "message"),
    [
        ("<robot>", "The text is no XML"),
        ("<mujoco/>", "begins with <mujoco>: expected <robot>"),
        (ARM.replace('xyz="0 0 2"', 'xyz="0 0 0"'), "'lift' has the axis \\(0, 0, 0\\)"),
        (ARM.replace('xyz="0 0 2"', 'xyz="0 1"'), "xyz='0 1'>: expected 3 numbers"),
        (ARM.replace('<parent link="column"/>', ""), "'turn' has no <parent>"),
        (ARM.replace('<parent link="column"/>', '<parent link="x"/>'), "'turn' names 'x'"),
        ('<?xml version="1.0" encoding="klingon"?><robot/>', "no XML: unknown encoding"),
        (XACRO, "macros of xacro, such as <xacro:arm>: expected .* that they make: xacro robot"),
        (ARM.replace('<link name="hand"/>', "<link/>"), "<link> has no name="),
        (ARM.replace('type="continuous"', ""), "Joint 'turn': <joint> has no type="),
        (ARM.replace('<link name="hand"/>', '<link name="hand"/>' * 2), "links are called 'hand'"),
        (ARM.replace('name="turn"', 'name="lift"'), "Several joints are called 'lift'"),
    ],
)
def test_what_is_no_description_is_an_error(source: str, message: str) -> None:
    with pytest.raises(OptionError, match=message):
        read_urdf(source)


@pytest.mark.parametrize(
    ("number", "other", "message"),
    [
        ('lower="0.1"', 'lower="nan"', "Joint 'lift': <limit lower='nan'>: expected a number"),
        ('lower="0.1"', 'lower="0,1"', "Joint 'lift': <limit lower='0,1'>: expected a number"),
        ('lower="0.1"', 'lower="0.9"', "<limit lower='0.9' upper='0.5'>: expected lower below"),
        ('velocity="0.2"', 'velocity="nan"', "Joint 'lift': <limit velocity='nan'>"),
        ('velocity="0.2"', 'velocity="-1"', "Joint 'lift': <limit velocity='-1'>"),
        ('xyz="0 0 2"', 'xyz="nan 0 1"', "Joint 'lift': <axis xyz='nan 0 1'>: expected 3 numbers"),
        ('xyz="0 0 2"', 'xyz="1e300 0 1"', "Joint 'lift': <axis xyz='1e300 0 1'>"),
        ('rpy="0.4 -0.5 0.6"', 'rpy="inf 0 0"', "Joint 'turn': <origin rpy='inf 0 0'>"),
        ('xyz="0.1 0.2 0.3"', 'xyz="a b c"', "Joint 'turn': <origin xyz='a b c'>"),
    ],
)
def test_a_number_that_is_none_is_an_error_that_names_the_element(
    number: str, other: str, message: str
) -> None:
    assert number in ARM
    with pytest.raises(OptionError, match=message):
        read_urdf(ARM.replace(number, other))


@pytest.mark.parametrize(
    ("limits", "others"),
    [
        ('<limit lower="0.1" upper="0.5" velocity="0.2" effort="1"/>', ""),
        ('lower="0.1" upper="0.5"', ""),
        ('lower="0.1" upper="0.5"', 'lower="0.5" upper="0.5"'),
    ],
)
def test_a_joint_of_the_chain_without_room_between_its_limits_is_an_error(
    limits: str, others: str
) -> None:
    tree = read_urdf(ARM.replace(limits, others))  # a gripper may have none
    with pytest.raises(OptionError, match="Joint 'lift' is prismatic and has no room to move"):
        tree.path()


@pytest.mark.parametrize("source", [None, 3, Path(__file__).parent, ""])
def test_what_is_neither_a_file_nor_a_text_is_an_error(source: Any) -> None:
    with pytest.raises(OptionError, match="expected a file"):
        read_urdf(source)


def test_a_file_is_not_read_beyond_its_bound(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(files, "LARGEST_DESCRIPTION", 1_000_000)
    file = tmp_path / "arm.urdf"
    with file.open("wb") as opened:
        opened.truncate(2_000_000)  # a hole: it takes no room
    with pytest.raises(OptionError, match="arm.urdf has 2 MB: expected at most 1 MB"):
        read_urdf(file)


@pytest.mark.parametrize("name", ["no_such.urdf", "a" * 5000, "a\0b"])
def test_a_missing_file_is_an_error(name: str) -> None:
    with pytest.raises(FileNotFoundError, match="is no file"):
        read_urdf(name)


def test_more_links_than_a_robot_has_are_an_error() -> None:
    many = "".join(f'<link name="{number}"/>' for number in range(1001))
    with pytest.raises(OptionError, match="The robot has 1001 links: expected at most 1000"):
        read_urdf(f"<robot>{many}</robot>")
