"""The pushing figure: what it shows is what happened and what the policy knew, and all files are written."""

import json
import sys
from pathlib import Path
from typing import Any

import imageio.v2 as imageio
import numpy as np
import pytest
from PIL import Image

import figures
from aicon_baselines.evaluation import ComparisonError, figures.pusht
from aicon_baselines.figures.pusht import (
    Recording,
    at_corners,
    choose_panels,
    draw_video,
    make_figure,
    phase,
    record,
    summary,
)
from aicon_envs.pusht.simulation import PUSHER_RADIUS, SUB_STEP
from aicon_torch import make_policy
from aicon_torch.parts.contact import inward
from aicon_torch.parts.contact_dynamics import ContactDynamics
from aicon_torch.parts.rigid_object import Outline

SEED = 1050


@pytest.fixture(scope="module")
def episode() -> Recording:
    return record(make_policy("pusht"), SEED)


def test_beliefs_are_where_the_world_is(episode: Recording) -> None:
    believed = np.stack([memory["x_pusher"].numpy() for memory in episode.memories])
    np.testing.assert_allclose(believed, episode.pushers, atol=1.0)
    for moment, memory in enumerate(episode.memories):
        corners = memory["x_side"].numpy()[:, :2]
        distances = np.linalg.norm(corners[:, np.newaxis] - episode.corners(moment), axis=-1)
        assert distances.min(axis=1).max() < 1.0


def test_useful_contacts_are_those_that_lower_the_cost(episode: Recording) -> None:
    outline = Outline.of()
    dynamics = ContactDynamics(outline, length=1.55 * outline.gyration)
    weights = np.array([1.0, 1.0, dynamics.length])
    for moment, memory in enumerate(episode.memories):
        effects = dynamics.effects(memory["x_obj"], memory["x_contact"], inward(memory["x_side"])).numpy()
        error = (memory["x_obj"] - memory["x_target"]).numpy()
        error[2] = (error[2] + np.pi) % (2 * np.pi) - np.pi
        cost = np.linalg.norm(weights * error)
        np.testing.assert_allclose(episode.costs[moment], cost, rtol=1e-9)
        np.testing.assert_allclose(episode.gains[moment], effects @ (weights**2 * error) / cost, atol=1e-9)


def test_way_between_the_moments_is_the_controllers(episode: Recording) -> None:
    np.testing.assert_allclose(episode.ways[:, 0], episode.pushers[:-1])
    np.testing.assert_allclose(episode.ways[:, -1], episode.pushers[1:])
    speeds = np.diff(episode.ways, axis=1)[:, -1] / SUB_STEP
    np.testing.assert_allclose(speeds, episode.velocities[1:], atol=1e-2)  # targets are sent as float32


def test_default_episode_shows_the_story(episode: Recording) -> None:
    contact, harmful, conflict, around, corner, last = (panel.step for panel in choose_panels(episode))
    assert contact < harmful < conflict < around < corner < last == episode.steps
    assert episode.touched[contact]
    assert not episode.touched[:contact].any()
    assert not episode.useful[harmful, episode.strengths[harmful].argmax()]
    assert episode.exploring[[conflict, corner]].all()
    assert not episode.exploring[[contact, harmful, around]].any()
    assert not episode.touched[[conflict, around]].any()
    assert at_corners(episode)[corner]
    assert episode.ending == "arrival"
    assert episode.costs[-1] < 0.05 * episode.costs[0]


def test_exploration_is_across_the_strongest_gradient(episode: Recording) -> None:
    conflict = choose_panels(episode)[2].step
    strongest = episode.descents[conflict, episode.strengths[conflict].argmax()]
    motion = episode.motions[conflict]
    cosine = motion @ strongest / (np.linalg.norm(motion) * np.linalg.norm(strongest))
    assert abs(cosine) < 0.2


@pytest.mark.parametrize("limit", [6, 7, 12, 30])
def test_panels_are_in_order_in_any_episode(limit: int) -> None:
    recording = record(make_policy("pusht", explore=False), 1011, limit)
    panels = choose_panels(recording)
    assert recording.ending == "time limit"
    assert panels[-1].title == "Out of time"
    assert all(np.diff([panel.step for panel in panels]) > 0)
    assert summary(recording, panels)["explorations_s"] == []


def test_too_short_an_episode_is_an_error() -> None:
    with pytest.raises(ComparisonError, match="5 steps"):
        choose_panels(record(make_policy("pusht"), SEED, limit=5))


def test_corners_are_near(episode: Recording) -> None:
    for moment in np.flatnonzero(at_corners(episode)):
        distances = np.linalg.norm(episode.corners(int(moment)) - episode.pushers[moment], axis=1)
        assert distances.min() < PUSHER_RADIUS + 11.0


def test_every_moment_has_a_phase(episode: Recording) -> None:
    phases = [phase(episode, moment) for moment in range(episode.steps + 1)]
    assert all(
        ("exploring" in each) == explores for each, explores in zip(phases[:-1], episode.exploring, strict=False)
    )
    assert phases[-1] == "PartialPath in the goal pose"


def test_all_files_are_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(figures.pusht, "record", lambda policy, seed: record(policy, seed, limit=8))
    numbers = make_figure(SEED, tmp_path / "figures", "gif", progress=False)
    assert json.loads((tmp_path / "figures" / "pusht_rollout.json").read_text()) == numbers
    assert {"seed", "ending", "steps", "duration_s", "path_length_px", "panels", "explorations_s"} <= numbers.keys()
    picture = tmp_path / "figures" / "pusht_rollout.png"
    with Image.open(picture) as image:
        assert image.size == (1820, 1326)
    assert picture.stat().st_size < 3e5
    assert len(imageio.mimread(tmp_path / "figures" / "pusht_rollout.gif")) > 3


def test_mp4(tmp_path: Path) -> None:
    pytest.importorskip("imageio_ffmpeg")
    path = tmp_path / "rollout.mp4"
    recording = record(make_policy("pusht"), SEED, limit=2)
    drawn: list[None] = []
    draw_video(recording, path, lambda: drawn.append(None))
    assert len(drawn) == 3
    reader: Any
    with imageio.get_reader(path) as reader:
        assert reader.get_meta_data()["fps"] == 10
        assert reader.get_data(0).shape == (704, 800, 3)


def test_script_says_what_the_figure_shows(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.setattr(sys, "argv", ["figures.py", "pusht", "--out", str(tmp_path), "--video", "none"])
    figures.main()
    said = capsys.readouterr().out
    assert said.startswith("arrival after")
    assert "(f)" in said
    assert (tmp_path / "pusht_rollout.png").stat().st_size < 3e5


def test_unknown_video_is_an_error_that_lists_the_valid_ones(tmp_path: Path) -> None:
    with pytest.raises(ComparisonError, match="mp4, gif, none"):
        make_figure(SEED, tmp_path, "avi", progress=False)
