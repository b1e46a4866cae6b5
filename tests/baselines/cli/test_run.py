"""The commands `aicon run`, `aicon bench` and `aicon figures`."""

from pathlib import Path

import pytest
from PIL import Image, ImageSequence

from aicon_baselines.cli.main import main


def test_run_tells_the_outcome_and_the_last_decision(
    capsys: pytest.CaptureFixture[str],
) -> None:
    main(["run", "--task", "nav2d", "--policy", "steepest,max_speed=0.3", "--horizon", "20"])
    outcome, _, explanation = capsys.readouterr().out.partition("its last step:")
    assert outcome.startswith("no success after 1 s; path ")
    assert "goal reach: cost" in explanation and "rank 0: reach → p_tar → x_rob" in explanation


def test_run_senses_what_an_opponent_needs_and_tells_what_it_does(
    capsys: pytest.CaptureFixture[str],
) -> None:
    main(["run", "--task", "nav2d", "--policy", "bug2,clearance=0.1", "--horizon", "20"])
    _, _, explanation = capsys.readouterr().out.partition("its last step:")
    assert explanation.strip() == "heads for the target"


def test_run_saves_a_film(tmp_path: Path) -> None:
    film = tmp_path / "films" / "film.gif"
    main(["run", "--task", "nav2d", "--horizon", "5", "--no-compile", "--video", str(film)])
    with Image.open(film) as picture:
        assert getattr(picture, "n_frames", 1) == 5


@pytest.mark.slow
def test_a_film_lasts_as_long_as_the_episode_and_shows_its_end(tmp_path: Path) -> None:
    if not pytest.importorskip("_arm_push_env").RENDERS:
        pytest.skip("no OpenGL")
    film = tmp_path / "film.gif"
    main(["run", "--task", "reach", "--horizon", "8", "--no-compile", "--video", str(film)])
    with Image.open(film) as picture:
        frames = [frame.info["duration"] for frame in ImageSequence.Iterator(picture)]

    # A picture after every second step of 20 ms, and after the last.
    assert frames == [40] * 5


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--policy", "oracle"], "unknown policy 'oracle'"),
        (["--policy", "law.no_such=1"], "law"),
        (["--condition", "rain"], "unknown condition 'rain'; valid conditions: range"),
        (["--video", "film.avi", "--horizon", "2"], "a video ends in .mp4 or .gif"),
    ],
)
def test_run_says_what_is_wrong(
    words: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit, match="2"):
        main(["run", "--task", "nav2d", *words])
    assert message in capsys.readouterr().err


@pytest.mark.slow
def test_bench_prints_both_times_and_their_ratio(capsys: pytest.CaptureFixture[str]) -> None:
    main(["bench", "--tasks", "nav2d", "--rounds", "3", "--steps", "5"])
    table = capsys.readouterr().out.splitlines()[2:]
    assert table[0] == "| task | uncompiled | compiled | times as fast |"
    assert table[2].startswith("| nav2d | ") and len(table) == 3


def test_figures_refuses_a_map_that_is_none(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit, match="2"):
        main(["figures", "nav2d", "--map", "moon", "--out", str(tmp_path)])
    assert "moon" in capsys.readouterr().err
