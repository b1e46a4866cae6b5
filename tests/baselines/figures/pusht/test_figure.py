"""All files of the pushing figure are written, and its timelines can be read."""

import copy
import json
from pathlib import Path
from typing import Any

import imageio.v2 as imageio
import numpy as np
import pytest
from _inputs import driven
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from PIL import Image

from aicon_baselines.evaluation import ComparisonError
from aicon_baselines.figures import rollout
from aicon_baselines.figures.pusht import PushRecording, PushRollout, figure, make_figure, record
from aicon_baselines.figures.pusht.view import PushView
from aicon_baselines.figures.rollout import RolloutFilm, draw_film

SEED = 1043


def test_all_files_are_written_and_the_summary_says_what_they_show(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, episode: PushRecording
) -> None:
    monkeypatch.setattr(figure, "record", lambda policy, seed: episode)
    monkeypatch.setattr(rollout, "DURATION", 1.0)
    folder = tmp_path / "figures"
    summary = make_figure(folder, video="webp")
    numbers = summary.numbers

    assert json.loads((folder / "pusht_rollout.json").read_text()) == numbers
    expected = {"seed", "ending", "steps", "duration_s", "path_length_px", "panels"}
    assert expected | {"explorations_s"} <= numbers.keys()

    with Image.open(folder / "pusht_rollout.png") as image:
        assert image.size == (1820, 1335)
    assert (folder / "pusht_rollout.png").stat().st_size < 3e5
    assert len(imageio.mimread(folder / "pusht_rollout.webp")) > 3
    assert all(path.exists() for path in summary.files)
    assert str(summary).startswith("arrival after")
    assert "(f)" in str(summary)


def test_a_film_holds_its_last_frame(episode: PushRecording) -> None:
    first, *last = RolloutFilm(PushRollout(episode), 1.0, dpi=20).frames([4, 7], hold=2)
    assert len(last) == 3
    np.testing.assert_equal(last, [last[0]] * 3)
    assert (first != last[0]).any()


def test_a_pusher_at_rest_has_no_arrow(episode: PushRecording) -> None:
    """As where nothing is read."""
    resting = copy.copy(episode)
    resting.__dict__["motions"] = np.zeros_like(episode.motions)
    shown = []
    for recording in (episode, resting):
        axes = Figure().subplots()
        PushView(axes, recording).show(4)
        shown.append(len(axes.patches))
    assert shown[1] == shown[0] - 1


def test_mp4(tmp_path: Path) -> None:
    pytest.importorskip("imageio_ffmpeg")
    path = tmp_path / "rollout.mp4"
    draw_film(PushRollout(record(driven("pusht"), SEED, limit=2)), path)

    reader: Any
    with imageio.get_reader(path) as reader:
        assert reader.get_meta_data()["fps"] == 10
        assert reader.get_data(0).shape == (720, 800, 3)
        assert reader.get_meta_data()["duration"] == pytest.approx(0.3 + 1.0)


def test_no_colour_stands_for_two_curves(episode: PushRecording) -> None:
    diagrams = Figure().subplots(2)
    PushRollout(episode).draw_curves(*diagrams)
    for axes in diagrams:
        colors = [to_hex(line.get_color()) for line in axes.lines]
        assert len(set(colors)) == len(colors)


def test_unknown_video_is_an_error_that_lists_the_valid_ones(tmp_path: Path) -> None:
    with pytest.raises(ComparisonError, match="mp4, webp, none"):
        make_figure(tmp_path, SEED, "avi")
