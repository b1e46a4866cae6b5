"""Pictures and videos: their size, their colours and their errors."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import imageio.v2 as imageio
import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image

from aicon_baselines.evaluation import ComparisonError
from aicon_baselines.figures.rendering import (
    Frame,
    mark,
    render,
    save_picture,
    save_video,
)
from aicon_baselines.figures.summary import FigureFiles


def frames(count: int) -> Iterator[Frame]:
    for index in range(count):
        frame = np.zeros((160, 320, 3), np.uint8)
        frame[..., 0 if index % 2 else 2] = 250
        yield frame


def test_saved_picture_looks_like_the_rendered_one(tmp_path: Path) -> None:
    figure = Figure(figsize=(2, 1), dpi=50, facecolor="#123457")
    save_picture(figure, tmp_path / "picture.png")

    with Image.open(tmp_path / "picture.png") as image:
        assert image.size == (100, 50)
        difference = np.asarray(image).astype(int) - render(figure)
    assert np.abs(difference).max() <= 2


@pytest.mark.parametrize(("height", "width"), [(100, 150), (101, 151)])
def test_an_mp4_has_the_size_of_its_frames_and_nothing_is_said_of_it(
    height: int, width: int, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    path = tmp_path / "video.mp4"
    save_video([np.zeros((height, width, 3), np.uint8)] * 3, path, 5)
    assert not caplog.records

    with imageio.get_reader(path) as video:
        assert video.get_data(0).shape == (100, 150, 3)


def test_a_webp_moves_and_is_small(tmp_path: Path) -> None:
    path = tmp_path / "new" / "video.webp"
    save_video(frames(6), path, 5)

    with Image.open(path) as image:
        assert image.n_frames == 6 and image.size == (320, 160)
        first = np.asarray(image.convert("RGB")).astype(int)
    assert np.abs(first[80, 160] - [0, 0, 250]).max() < 20
    assert path.stat().st_size < 5_000


def test_mp4_has_the_rate_and_the_size(tmp_path: Path) -> None:
    pytest.importorskip("imageio_ffmpeg")
    path = tmp_path / "video.mp4"
    save_video(frames(20), path, 10)

    reader: Any
    with imageio.get_reader(path) as reader:
        assert reader.get_meta_data()["fps"] == 10
        assert reader.get_data(0).shape == (160, 320, 3)
        assert reader.get_meta_data()["duration"] == pytest.approx(2.0)


def test_unknown_format_is_an_error_that_lists_the_valid_ones(tmp_path: Path) -> None:
    with pytest.raises(ComparisonError, match="mp4, webp, none"):
        FigureFiles(tmp_path, "film", "avi")


def test_a_ball_is_added_to_a_scene_at_its_place() -> None:
    mujoco = pytest.importorskip("mujoco")
    scene = mujoco.MjvScene(mujoco.MjModel.from_xml_string("<mujoco/>"), 2)
    mark(scene, (0.1, 0.2, 0.3), radius=0.02, color=(1.0, 0.0, 0.0, 0.5))

    (ball,) = scene.geoms[: scene.ngeom]
    assert ball.type == mujoco.mjtGeom.mjGEOM_SPHERE
    np.testing.assert_allclose(ball.pos, (0.1, 0.2, 0.3), rtol=1e-6)
    np.testing.assert_allclose(ball.size, 0.02, rtol=1e-6)
    np.testing.assert_allclose(ball.rgba, (1.0, 0.0, 0.0, 0.5))
