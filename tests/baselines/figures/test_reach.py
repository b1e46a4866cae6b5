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
from aicon_baselines.figures.reach import ReachRollout, draw_picture, make_figure, record_reach
from aicon_baselines.figures.rollout import draw_film


@pytest.fixture(scope="module")
def episode() -> Recording:
    try:
        return record_reach("ur5_pose_home", seed=1000, horizon=7)
    except RuntimeError as error:
        pytest.skip(f"no OpenGL without a display: {error}")


def test_every_second_step_and_the_end_are_seen_and_every_step_is_measured(
    episode: Recording,
) -> None:
    assert len(episode.memories) == 4 and episode.pictures[0].shape == (480, 480, 3)
    assert not np.array_equal(episode.pictures[0], episode.pictures[-1])
    np.testing.assert_allclose(episode.times, 0.04 * np.arange(4))
    for name in ("distance", "angle", "self_gap", "limit_margin"):
        values = episode.told(name)
        assert values.shape == (5,) and (values > 0.0).all()


def test_the_picture_shows_each_robot(episode: Recording, tmp_path: Path) -> None:
    draw_picture({"ur5": episode, "again": episode}, tmp_path / "reach.png")
    with Image.open(tmp_path / "reach.png") as picture:
        assert picture.width > 1000 and picture.height > 500


def test_the_film_shows_every_picture_with_its_phase(episode: Recording, tmp_path: Path) -> None:
    rollout = ReachRollout(episode)
    draw_film(rollout, tmp_path / "reach.webp")
    with Image.open(tmp_path / "reach.webp") as film:
        assert film.n_frames >= len(episode.memories)
    assert rollout.phase(episode.steps - 1) == "Out of time"


def test_the_curves_are_those_of_the_episode(episode: Recording) -> None:
    axes = Figure().add_subplot()
    ReachRollout(episode).draw_curves(axes)
    np.testing.assert_array_equal(axes.lines[0].get_ydata(), episode.told("distance")[:-1])
    np.testing.assert_array_equal(axes.lines[2].get_ydata(), episode.told("self_gap")[:-1])


def test_an_unknown_format_is_an_error_before_anything_runs(tmp_path: Path) -> None:
    with pytest.raises(ComparisonError, match="unknown video 'avi'; valid videos: mp4, webp, none"):
        make_figure(tmp_path, video="avi")
