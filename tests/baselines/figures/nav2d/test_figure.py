"""All files of the navigation figure are written, and its timeline can be read."""

import json
from pathlib import Path
from typing import Any

import imageio.v2 as imageio
import pytest
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from PIL import Image

from aicon_baselines.evaluation import ComparisonError
from aicon_baselines.figures import rollout
from aicon_baselines.figures.nav2d import NavigationRecording, NavigationRollout, make_figure
from aicon_baselines.figures.rollout import draw_film, film_steps

MAP, SEED = "u_trap_05", 1000


@pytest.mark.slow
def test_all_files_are_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rollout, "DURATION", 1.0)
    folder = tmp_path / "figures"
    summary = make_figure(folder, SEED, "webp", map_name=MAP, spacing=0.2)
    numbers = summary.numbers

    assert json.loads((folder / "nav2d_rollout.json").read_text()) == numbers
    expected = {"map", "seed", "panels", "steps", "path_length_m", "explorations_s"}
    assert expected <= numbers.keys()
    assert list(numbers["trace_sigma_m2"]) == ["0 s", "1 s", "5 s"]
    assert numbers["path_length_m"] >= numbers["shortest_path_m"] - 0.2

    with Image.open(folder / "nav2d_rollout.png") as image:
        assert image.size == (1820, 1066)
    assert (folder / "nav2d_rollout.png").stat().st_size < 1e6
    assert len(imageio.mimread(folder / "nav2d_rollout.webp")) > 3

    assert all(path.exists() for path in summary.files)
    assert str(summary).startswith(f"arrival after {numbers['duration_s']} s")
    assert "(f)" in str(summary)


def test_mp4(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, recording: NavigationRecording
) -> None:
    pytest.importorskip("imageio_ffmpeg")
    monkeypatch.setattr(rollout, "DURATION", 0.2)
    path = tmp_path / "rollout.mp4"
    shown = NavigationRollout(recording, spacing=0.2)
    draw_film(shown, path)

    rate, steps = 15, film_steps(shown, rate=15)
    assert len(steps) > 1
    reader: Any
    with imageio.get_reader(path) as reader:
        assert reader.get_data(0).shape == (540, 800, 3)
        duration = reader.get_meta_data()["duration"]
    assert rate * duration == pytest.approx(len(steps) + rate, abs=0.2)


def test_no_colour_stands_for_two_curves(recording: NavigationRecording) -> None:
    axes = Figure().add_subplot()
    NavigationRollout(recording).draw_curves(axes)
    colors = [to_hex(line.get_color()) for line in axes.lines]
    assert len(set(colors)) == len(colors) == 4


def test_unknown_names_are_errors_that_list_the_valid_ones(tmp_path: Path) -> None:
    with pytest.raises(ComparisonError, match="u_trap_2"):
        make_figure(tmp_path, SEED, "none", map_name="u_trop")
    with pytest.raises(ComparisonError, match="mp4, webp, none"):
        make_figure(tmp_path, SEED, "avi", map_name=MAP)
