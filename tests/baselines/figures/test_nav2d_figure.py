"""The navigation figure: the field it shows is the one that the agent follows, and all files are written."""

import importlib.util
import json
import sys
from pathlib import Path
from typing import Any

import imageio.v2 as imageio
import numpy as np
import pytest
from PIL import Image

from aicon_baselines.evaluation import ComparisonError
from aicon_baselines.figures.nav2d import (
    Grid,
    Recording,
    choose_panels,
    clearance,
    draw_video,
    make_figure,
    record,
    sample,
    summary,
    video,
    video_steps,
)
from aicon_envs.nav2d import NavigationMap
from aicon_torch import make_policy
from aicon_torch.control import ActionLaw

SCRIPT = Path(__file__).parent.parent / "scripts" / "figures.py"
MAP, SEED = "u_trap_05", 1000
BLOCK = NavigationMap("block", [[(-0.5, -0.4), (0.6, -0.4), (0.6, 0.3), (-0.5, 0.3)]], (-2.0, 0.0), (2.0, 0.0))


@pytest.fixture(scope="module")
def followed() -> tuple[Recording, list[Any]]:
    """A rollout, and the gradient at the action that the policy followed in each step."""
    gradients: list[Any] = []

    class Law(ActionLaw):
        def __call__(self, gradient: Any, *rest: Any) -> Any:
            gradients.append(gradient.numpy() / rest[-1])
            return super().__call__(gradient, *rest)

    policy = make_policy("nav2d")
    policy.law = Law(policy.law.gain, policy.law.accumulate, policy.law.smoothing)
    return record(policy, MAP, SEED), gradients


def test_field_where_the_agent_is_is_what_it_followed(followed: tuple[Recording, list[Any]]) -> None:
    recording, gradients = followed
    assert recording.exploring.any()
    assert not recording.exploring.all()
    for step in range(1, recording.steps, 3):
        field = sample(recording, step, recording.positions[[step]], obstacle="remembered")
        np.testing.assert_allclose(-field.descent[0], gradients[step], rtol=0, atol=1e-9)
        assert field.exploring[0] == recording.exploring[step]


def test_field_does_not_depend_on_its_batch(followed: tuple[Recording, list[Any]]) -> None:
    recording, _ = followed
    points = recording.positions[[10, 40, -1]] + 0.01
    together = sample(recording, 30, points).descent
    alone = [sample(recording, 30, points[[index]]).descent[0] for index in range(3)]
    np.testing.assert_allclose(together, alone, rtol=0, atol=1e-12)


def test_first_step_has_no_memory_before_it(followed: tuple[Recording, list[Any]]) -> None:
    with pytest.raises(ValueError, match="step=0"):
        sample(followed[0], 0, np.zeros((1, 2)))


def test_panels_are_in_order(followed: tuple[Recording, list[Any]]) -> None:
    recording, _ = followed
    panels = choose_panels(recording)
    steps = [panel.step for panel in panels]
    assert len(steps) == len("abcdef")
    assert steps[0] >= 1
    assert steps[-1] == recording.steps - 1
    assert all(np.diff(steps) > 0)
    times = [panel["time_s"] for panel in summary(recording, panels)["panels"]]
    assert all(np.diff(times) > 0)


def test_panels_are_in_order_without_exploration() -> None:
    recording = record(make_policy("nav2d", explore=False), MAP, SEED, limit=60)
    steps = [panel.step for panel in choose_panels(recording)]
    assert all(np.diff(steps) > 0)


def test_default_rollout_shows_the_story() -> None:
    recording = record(make_policy("nav2d"), "u_trap_2", 1006)
    panels = choose_panels(recording)
    assert recording.ending == "arrival"
    assert recording.strengths["p2"][panels[0].step] > recording.strengths["p1"][panels[0].step]
    assert recording.exploring[panels[1].step]
    assert not recording.exploring[panels[1].step - 1]
    assert all(recording.exploring[panel.step] for panel in panels[2:5])
    assert recording.uncertainty[100] < 0.1 * recording.uncertainty[0]


def test_clearance_is_the_environments(followed: tuple[Recording, list[Any]]) -> None:
    points = np.array([[-1.0, 0.0], [0.0, 1.0], [1.6, 1.3]])
    expected = [[0.4, -1.0, 0.0], [0.6, 0.0, 1.0], [np.sqrt(2) - 0.1, np.sqrt(0.5), np.sqrt(0.5)]]
    np.testing.assert_allclose(clearance(BLOCK, 0.1, points), expected, atol=1e-12)


def test_potential_recovers_the_one_that_was_sampled() -> None:
    grid = Grid(BLOCK, np.array([-2.0, -1.0]), np.array([2.0, 1.0]), 0.1)
    x, y = grid.points.T
    height = 0.3 * x**2 + 0.2 * x * y - y  # the trapezoidal rule along an edge is exact for a quadratic
    descent = -np.stack([0.6 * x + 0.2 * y, 0.2 * x - 1.0], axis=1)
    fitted = grid.potential(descent)
    assert not grid.free.all()
    assert (np.isnan(fitted) == ~grid.free).all()
    np.testing.assert_allclose(fitted[grid.free], height - height.min(), atol=1e-6)


def test_all_files_are_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(video, "_SECONDS", 1.0)
    numbers = make_figure(MAP, SEED, tmp_path / "figures", "gif", spacing=0.2, progress=False)
    assert json.loads((tmp_path / "figures" / "nav2d_rollout.json").read_text()) == numbers
    assert {"map", "seed", "panels", "steps", "path_length_m", "explorations_s", "trace_sigma_m2"} <= numbers.keys()
    assert list(numbers["trace_sigma_m2"]) == ["0 s", "1 s", "5 s"]
    assert numbers["path_length_m"] >= numbers["shortest_path_m"] - 0.2
    picture = tmp_path / "figures" / "nav2d_rollout.png"
    with Image.open(picture) as image:
        assert image.size == (2100, 1200)
    assert picture.stat().st_size < 1e6
    assert len(imageio.mimread(tmp_path / "figures" / "nav2d_rollout.gif")) > 3


def test_mp4(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, followed: tuple[Recording, list[Any]]) -> None:
    pytest.importorskip("imageio_ffmpeg")
    monkeypatch.setattr(video, "_SECONDS", 0.2)
    path = tmp_path / "rollout.mp4"
    drawn: list[None] = []
    draw_video(followed[0], path, 0.3, lambda: drawn.append(None))
    assert len(drawn) == len(video_steps(followed[0], path)) > 1
    reader: Any
    with imageio.get_reader(path) as reader:
        assert reader.get_data(0).shape == (528, 800, 3)


def test_unknown_names_are_errors_that_list_the_valid_ones(tmp_path: Path) -> None:
    with pytest.raises(ComparisonError, match="u_trap_2"):
        make_figure("u_trop", SEED, tmp_path, "none", progress=False)
    with pytest.raises(ComparisonError, match="mp4, gif, none"):
        make_figure(MAP, SEED, tmp_path, "avi", progress=False)


def test_script_reports_errors(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    spec = importlib.util.spec_from_file_location("figures", SCRIPT)
    assert spec
    assert spec.loader
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    monkeypatch.setattr(sys, "argv", ["figures.py", "nav2d", "--map", "u_trop", "--out", str(tmp_path)])
    with pytest.raises(SystemExit):
        script.main()
    assert "u_trap_2" in capsys.readouterr().err
