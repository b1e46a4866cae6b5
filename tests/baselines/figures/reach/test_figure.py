"""The figure of arms that reach: its files and what they show."""

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("mujoco")
pytest.importorskip("trimesh")
pytest.importorskip("pytorch_kinematics")

from matplotlib.figure import Figure
from PIL import Image

from aicon_baselines.evaluation import ComparisonError
from aicon_baselines.evaluation.recording import Recording
from aicon_baselines.figures.reach import draw_picture, make_figure, record_reach
from aicon_baselines.figures.reach.figure import ZOOM, captioned, draw_curves, draw_film


@pytest.fixture(scope="module")
def episode() -> Recording:
    try:
        return record_reach("ur5_pose_home", seed=1000, horizon=7)
    except RuntimeError as error:
        pytest.skip(f"no OpenGL without a display: {error}")


def test_every_second_step_and_the_end_are_seen_and_every_step_is_measured(
    episode: Recording,
) -> None:
    assert len(episode.pictures) == 5 and episode.pictures[0].shape == (480, 480, 3)
    assert not np.array_equal(episode.pictures[0], episode.pictures[-1])
    np.testing.assert_allclose(episode.times, 0.02 * np.arange(7))
    for name in ("distance", "angle", "self_gap", "limit_margin"):
        values = episode.told(name)[1:]
        assert values.shape == (7,) and (values > 0.0).all()


def test_the_picture_shows_each_robot(episode: Recording, tmp_path: Path) -> None:
    draw_picture({"ur5": episode, "again": episode}, tmp_path / "reach.png")
    with Image.open(tmp_path / "reach.png") as picture:
        assert picture.width > 1000 and picture.height > 500


def test_the_film_says_what_happens(episode: Recording, tmp_path: Path) -> None:
    draw_film("ur5", episode, tmp_path / "reach.webp")
    with Image.open(tmp_path / "reach.webp") as film:
        assert film.size == (320, 320) and film.n_frames > 2

    written = list(captioned("ur5", episode))
    assert len(written) == len(episode.pictures)
    for frame, picture in zip(written, episode.pictures, strict=True):
        plain = picture[ZOOM, ZOOM]
        assert (frame[:40] != plain[:40]).any() and (frame[50:] == plain[50:]).all()


def test_the_curves_are_those_of_the_episode(episode: Recording) -> None:
    axes = Figure().add_subplot()
    draw_curves(axes, episode)
    np.testing.assert_array_equal(axes.lines[0].get_ydata(), episode.told("distance")[1:])
    np.testing.assert_array_equal(axes.lines[2].get_ydata(), episode.told("self_gap")[1:])


def test_an_unknown_format_is_an_error_before_anything_runs(tmp_path: Path) -> None:
    with pytest.raises(ComparisonError, match="unknown video 'avi'; valid: mp4, webp, none"):
        make_figure(tmp_path, video="avi")
