"""Descriptions that are broken, or made to hang: an error names the file and the element."""

from pathlib import Path

import pytest

pytest.importorskip("mujoco")

from aicon_envs.reach import ReachEnv, Robot

LIMIT = '<limit lower="-1" upper="1" velocity="1" effort="1"/>'
ARM = f"""
<robot name="arm">
  <link name="base"/>
  <link name="upper"><collision><geometry><sphere radius="0.05"/></geometry></collision></link>
  <link name="hand"/>
  <joint name="turn" type="revolute">
    <parent link="base"/><child link="upper"/><axis xyz="0 0 1"/>{LIMIT}
  </joint>
  <joint name="lift" type="revolute">
    <parent link="upper"/><child link="hand"/>
    <origin xyz="0.3 0 0.2" rpy="0 0 0"/><axis xyz="0 1 0"/>{LIMIT}
  </joint>
</robot>"""


def build(folder: Path, text: str, tip: str = "hand") -> ReachEnv:
    file = folder / "arm.urdf"
    file.write_text(text)
    return ReachEnv(Robot(str(file), tip), "position")


def test_it_can_be_built(tmp_path: Path) -> None:
    assert build(tmp_path, ARM).action_space.shape == (2,)


@pytest.mark.parametrize(
    ("part", "other", "message"),
    [
        ("<robot", "<<", "arm.urdf is no XML"),
        ('lower="-1"', 'lower="nan"', "joint 'turn': <limit lower='nan'> must be numbers"),
        ('lower="-1"', 'lower="2"', "joint 'turn' must have a lower limit below.*got 2 and 1"),
        (LIMIT, "", "joint 'turn' must have a lower limit below the upper one, got 0 and 0"),
        ('velocity="1"', 'velocity="x"', "joint 'turn': <limit velocity='x'> must be numbers"),
        ("0 0 1", "0 nan 1", "joint 'turn': <axis xyz='0 nan 1'> must be numbers"),
        ("0.3 0 0.2", "1e12 0 0", "joint 'lift': <origin xyz='1e12 0 0'> must be numbers"),
        ('radius="0.05"', 'radius="nan"', "link 'upper': <sphere radius='nan'> must be numbers"),
        ("revolute", "planar", "joint 'turn' must be one of revolute, .*, got 'planar'"),
        ('name="lift"', 'name="turn"', "arm.urdf has 2 of the joint 'turn'; one is expected"),
        ('name="base"', 'name="hand"', "arm.urdf has 2 of the link 'hand'; one is expected"),
        ('parent link="base"', 'parent link="hand"', "joint '....' closes a loop"),
        ('child link="upper"', 'child link="hand"', "link 'hand' has the joints 'turn' and 'lift'"),
    ],
)
def test_what_is_wrong_is_named(part: str, other: str, message: str, tmp_path: Path) -> None:
    assert part in ARM
    with pytest.raises(ValueError, match=message):
        build(tmp_path, ARM.replace(part, other, 1))


def test_more_links_than_a_robot_has_are_an_error(tmp_path: Path) -> None:
    many = "".join(f'<link name="{number}"/>' for number in range(1000))
    with pytest.raises(ValueError, match="arm.urdf has 1003 links; at most 1000 are expected"):
        build(tmp_path, ARM.replace("</robot>", f"{many}</robot>"))


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("bomb.zip", "must end in one of .stl"),
        ("a.glb", "must end in"),
        ("a.ply", "cannot be read"),
    ],
)
def test_a_mesh_that_is_none_is_named(name: str, message: str, tmp_path: Path) -> None:
    pytest.importorskip("trimesh")
    (tmp_path / name).write_bytes(b"no mesh")
    mesh = f'<mesh filename="{name}"/>'
    with pytest.raises(ValueError, match=f"the mesh .*{name} {message}"):
        build(tmp_path, ARM.replace('<sphere radius="0.05"/>', mesh))


def test_a_file_is_not_read_beyond_its_bound(tmp_path: Path) -> None:
    file = tmp_path / "arm.urdf"
    with file.open("wb") as opened:
        opened.truncate(20_000_000)  # a hole: it takes no room
    with pytest.raises(ValueError, match="arm.urdf has 20 MB; at most 10 MB are expected"):
        ReachEnv(Robot(str(file), "hand"), "position")


def test_a_robot_that_always_touches_itself_is_an_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    env = build(tmp_path, ARM)
    monkeypatch.setattr("aicon_envs.reach.reset.EpisodeDrawer._gap", lambda *_: -0.01)
    with pytest.raises(ValueError, match="the robot touches itself wherever its joints are"):
        env.reset(seed=0)
