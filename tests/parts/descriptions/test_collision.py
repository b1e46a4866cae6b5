from pathlib import Path

import numpy as np
import pytest

from aicon_torch.errors import OptionError
from aicon_torch.parts.descriptions import collision
from aicon_torch.parts.descriptions.collision import find_mesh, read_collision_geometry

trimesh = pytest.importorskip("trimesh")


def robot(shape: str, origin: str = "") -> str:
    collision = f"<collision>{origin}<geometry>{shape}</geometry></collision>"
    return f'<robot name="r"><link name="a">{collision}</link><link name="b"/></robot>'


def test_primitives_keep_their_numbers() -> None:
    origin = '<origin xyz="1 2 3" rpy="0 0 0"/>'
    shapes = '<cylinder radius="0.1" length="0.4"/>', '<sphere radius="0.2"/>'
    found = [read_collision_geometry(robot(shape, origin))["a"].cylinders[0] for shape in shapes]

    assert [tuple(each[1:]) for each in found] == [(0.4, 0.1, False), (0.0, 0.2, True)]
    assert found[0].pose[:3, 3].tolist() == [1.0, 2.0, 3.0]


def test_links_without_geometry_are_left_out() -> None:
    assert set(read_collision_geometry(robot('<sphere radius="1"/>'))) == {"a"}


def test_a_box_is_where_its_origin_puts_it() -> None:
    (triangles,) = read_collision_geometry(
        robot('<box size="0.2 0.4 0.6"/>', '<origin xyz="1 0 0" rpy="0 0 1.5707963267948966"/>')
    )["a"].triangles
    assert triangles.shape == (12, 3, 3)
    np.testing.assert_allclose(triangles.min(axis=(0, 1)), [0.8, -0.1, -0.3])
    np.testing.assert_allclose(triangles.max(axis=(0, 1)), [1.2, 0.1, 0.3])


@pytest.mark.parametrize("name", ["package://my_robot/meshes/part.stl", "../meshes/part.stl"])
def test_a_mesh_is_found_by_its_package_or_its_path(tmp_path: Path, name: str) -> None:
    package = tmp_path / "my_robot"
    for folder in ("urdf", "meshes"):
        (package / folder).mkdir(parents=True)
    trimesh.creation.box(extents=(100, 200, 300)).export(package / "meshes" / "part.stl")

    file = package / "urdf" / "robot.urdf"
    file.write_text(robot(f'<mesh filename="{name}" scale="0.001 0.001 0.001"/>'))
    (triangles,) = read_collision_geometry(file)["a"].triangles
    np.testing.assert_allclose(np.ptp(triangles, axis=(0, 1)), [0.1, 0.2, 0.3], rtol=1e-6)


def test_a_mesh_that_is_not_there_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match="package://r/part.stl is neither in"):
        find_mesh("package://r/part.stl", tmp_path)


def test_an_unknown_shape_is_an_error() -> None:
    with pytest.raises(OptionError, match="<cone> is no shape; expected box, capsule"):
        read_collision_geometry(robot("<cone/>"))


@pytest.mark.parametrize(
    ("shape", "message"),
    [
        ('<sphere radius="nan"/>', "Link 'a': <sphere radius='nan'>: expected a number above 0"),
        ('<sphere radius="-1"/>', "Link 'a': <sphere radius='-1'>: expected a number above 0"),
        ("<sphere/>", "Link 'a': <sphere> has no radius=; expected a number above 0"),
        ('<cylinder radius="1"/>', "Link 'a': <cylinder> has no length="),
        ('<capsule radius="0" length="1"/>', "Link 'a': <capsule radius='0'>"),
        ('<box size="1 1"/>', "Link 'a': <box size='1 1'>: expected 3 numbers"),
        ('<box size="1 1 -1"/>', "Link 'a': <box size='1 1 -1'>: expected 3 numbers above 0"),
        ("<mesh/>", "Link 'a': <mesh> has no filename="),
    ],
)
def test_a_shape_of_no_size_is_an_error_that_names_the_link(shape: str, message: str) -> None:
    with pytest.raises(OptionError, match=message):
        read_collision_geometry(robot(shape))


def test_more_shapes_than_a_robot_has_are_an_error() -> None:
    shape = '<sphere radius="1"/></geometry></collision><collision><geometry>' * 1500
    with pytest.raises(OptionError, match="1501 shapes that collide: expected at most 300"):
        read_collision_geometry(robot(shape))


def test_the_triangles_of_all_links_together_are_bounded(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(collision, "MOST_TRIANGLES", 20)
    trimesh.creation.box().export(tmp_path / "box.stl")
    file = tmp_path / "robot.urdf"
    file.write_text(robot('<mesh filename="box.stl"/>'))
    assert len(read_collision_geometry(file)["a"].triangles[0]) == 12

    file.write_text(
        robot('<box size="1 1 1"/>')
        .replace('name="b"/>', 'name="b">')
        .replace(
            "</robot>",
            '<collision><geometry><mesh filename="box.stl"/></geometry></collision></link></robot>',
        )
    )
    with pytest.raises(OptionError, match="more than 20 triangles, up to those of link 'b'"):
        read_collision_geometry(file)


def test_a_name_longer_than_any_file_has_is_an_error_by_name() -> None:
    with pytest.raises(FileNotFoundError, match="is neither in"):
        read_collision_geometry(robot(f'<mesh filename="{"a" * 5000}.stl"/>'))
