"""The arm's film: its files, its curves and their colours."""

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("aicon_envs.arm_push")

import imageio.v2 as imageio
from _inputs import lean
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from PIL import Image

from aicon_baselines.evaluation import ComparisonError
from aicon_baselines.figures import arm_push
from aicon_baselines.figures.arm_push import ArmRecording, ArmRollout, make_figure, record_arm
from aicon_baselines.tasks.arm_push import TASK
from aicon_torch import Policy

SEED, HORIZON = 1000, 61


@pytest.fixture(scope="module")
def episode() -> ArmRecording:
    try:
        policy = lean("arm_push", **TASK.policy_options("camera"))
        return record_arm(policy, SEED, HORIZON)
    except RuntimeError as error:
        pytest.skip(f"no OpenGL without a display: {error}")


def test_every_tenth_step_is_recorded(episode: ArmRecording) -> None:
    np.testing.assert_allclose(episode.times, 0.1 * np.arange(7))
    assert episode.ending == "time limit"
    assert len(episode.distance) == 7 and episode.exploring.shape == (7,)
    assert episode.side_by_side(6).shape == (360, 960, 3)


def test_gradients_come_by_the_end_effector_or_straight_to_the_joints(
    episode: ArmRecording,
) -> None:
    assert {
        "joint_limits",
        "self_collision → x_body",
        "push → x_pusher",
    } <= episode.strengths.keys()
    assert not any("x_ee" in label for label in episode.strengths)
    for strengths in episode.strengths.values():
        assert strengths.shape == (7,)


def test_no_colour_stands_for_two_curves_and_none_is_left_out(episode: ArmRecording) -> None:
    strengths, errors = Figure().subplots(2)
    ArmRollout(episode).draw_curves(strengths, errors)
    assert len(strengths.lines) == len(episode.strengths)
    for axes in (strengths, errors):
        colors = [to_hex(line.get_color()) for line in axes.lines]
        assert len(set(colors)) == len(colors)


def test_all_files_are_written(
    episode: ArmRecording, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(arm_push, "record_arm", lambda *arguments, **options: episode)
    monkeypatch.setattr(Policy, "compile", lambda policy: policy)  # it takes no step
    summary = make_figure(tmp_path, video="webp")

    with Image.open(tmp_path / "arm_push_film.png") as image:
        assert image.width == 1820
    assert imageio.mimread(tmp_path / "arm_push_film.webp")[0].shape[1] == 480
    assert all(path.exists() for path in summary.files)
    assert str(summary).startswith("time limit after 0.7 s")


def test_unknown_video_is_an_error_that_lists_the_valid_ones(tmp_path: Path) -> None:
    with pytest.raises(ComparisonError, match="mp4, webp, none"):
        make_figure(tmp_path, SEED, "avi")
