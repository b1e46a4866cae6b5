"""Meshes that are broken, or made to fill the memory."""

import zipfile
from pathlib import Path

import numpy as np
import pytest

from aicon_torch.errors import OptionError
from aicon_torch.parts.descriptions import meshes
from aicon_torch.parts.descriptions.meshes import read_triangles

trimesh = pytest.importorskip("trimesh")

TRIANGLE = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]


def mesh_file(path: Path, corners: list[list[float]]) -> Path:
    """A mesh of one triangle."""
    trimesh.Trimesh(corners, [[0, 1, 2]], process=False).export(path)
    return path


def test_a_flat_mesh_is_read(tmp_path: Path) -> None:
    triangles = read_triangles(mesh_file(tmp_path / "flat.stl", TRIANGLE), "Link 'a'")
    np.testing.assert_allclose(triangles, [TRIANGLE])


@pytest.mark.parametrize(
    ("name", "content"), [("a.stl", b"garbage"), ("a.stl", b""), ("a.obj", b"f 1 1 1\n")]
)
def test_a_broken_mesh_is_an_error_that_names_it(tmp_path: Path, name: str, content: bytes) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(OptionError, match=f"Link 'a': the mesh .*{name}"):
        read_triangles(tmp_path / name, "Link 'a'")


def test_corners_on_one_line_are_an_error(tmp_path: Path) -> None:
    line = mesh_file(tmp_path / "line.stl", [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]])
    with pytest.raises(OptionError, match="all of its corners on one line"):
        read_triangles(line, "Link 'a'")


def test_corners_without_bound_are_an_error(tmp_path: Path) -> None:
    wide = mesh_file(tmp_path / "wide.stl", [[1e30, 0.0, 0.0], *TRIANGLE[1:]])
    with pytest.raises(OptionError, match="corners that are not finite, or beyond"):
        read_triangles(wide, "Link 'a'")


def test_one_corner_that_is_no_number_is_an_error(tmp_path: Path) -> None:
    corners = [*TRIANGLE, *TRIANGLE[:2], [0.0, float("nan"), 1.0]]
    file = tmp_path / "hole.stl"
    trimesh.Trimesh(corners, [[0, 1, 2], [3, 4, 5]], process=False).export(file)
    with pytest.raises(OptionError, match="hole.stl has corners that are not finite"):
        read_triangles(file, "Link 'a'")


@pytest.mark.parametrize("ending", [".glb", ".gltf", ".3mf"])
def test_what_unpacks_to_any_size_is_not_read(tmp_path: Path, ending: str) -> None:
    """glTF may name a million points, or instances, in a line."""
    file = tmp_path / f"part{ending}"
    file.write_bytes(b"glTF")
    with pytest.raises(OptionError, match=f"has the ending '{ending}': expected '.stl', '.dae'"):
        read_triangles(file, "Link 'a'")


def test_an_archive_is_not_unpacked(tmp_path: Path) -> None:
    bomb = tmp_path / "bomb.zip"
    with zipfile.ZipFile(bomb, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("part.stl", bytes(1000))
    with pytest.raises(OptionError, match=r"has the ending '.zip': expected '.stl', '.dae'"):
        read_triangles(bomb, "Link 'a'")


def test_a_scene_that_unfolds_without_end_is_an_error(tmp_path: Path) -> None:
    """Each node holds the next one twice: 2⁴⁰ of them."""
    nodes = "".join(
        f'<node id="n{i}"><instance_node url="#n{i + 1}"/><instance_node url="#n{i + 1}"/></node>'
        for i in range(40)
    )
    scene = '<visual_scene id="s"><instance_node url="#n0"/></visual_scene>'
    file = tmp_path / "unfolds.dae"
    file.write_text(f'<COLLADA>{nodes}<node id="n40"/>{scene}</COLLADA>')
    with pytest.raises(OptionError, match="scene has 2199023255552 nodes, expected at most"):
        read_triangles(file, "Link 'a'")

    loop = '<node id="n0"><instance_node url="#n0"/></node>'
    file.write_text(f"<COLLADA>{loop}{scene}</COLLADA>")
    with pytest.raises(OptionError, match="scene has inf nodes"):
        read_triangles(file, "Link 'a'")


def test_a_geometry_that_is_named_very_often_is_an_error(tmp_path: Path) -> None:
    corners = "<geometry id='g'><mesh><triangles><p>" + "0 1 2 " * 5000 + "</p></triangles></mesh>"
    nodes = "<node><instance_geometry url='#g'/></node>" * 300
    file = tmp_path / "often.dae"
    file.write_text(f"<COLLADA>{corners}</geometry><visual_scene>{nodes}</visual_scene></COLLADA>")
    with pytest.raises(
        OptionError, match="scene has 1500000 triangles, expected at most 1,000,000"
    ):
        read_triangles(file, "Link 'a'")


def test_the_number_of_triangles_is_bounded(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(meshes, "MOST_TRIANGLES", 10)
    file = tmp_path / "box.stl"
    trimesh.creation.box().export(file)
    with pytest.raises(OptionError, match="has 12 triangles: expected 1 to 10"):
        read_triangles(file, "Link 'a'")
