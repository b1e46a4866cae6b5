"""Demonstrations and what else of the diffusion policies needs no LeRobot; the rest is in test_diffusion_lerobot.py."""

import re
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("pymunk")

import collect_demos
import compare
import train_diffusion
from aicon_baselines.evaluation import ComparisonError
from aicon_baselines.agents.diffusion import demonstrations, hub
from aicon_baselines.agents.diffusion.dataset import Frames
from aicon_baselines.agents.diffusion.demonstrations import Recording, record_chunk
from aicon_baselines.agents.diffusion.settings import Training
from aicon_baselines.agents.registry import factory
from aicon_envs.pusht import PushTEnv


@pytest.fixture
def small_chunks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(demonstrations, "CHUNK", 3)


@pytest.fixture
def no_lerobot(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in [name for name in sys.modules if name.split(".")[0] == "lerobot"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "lerobot", None)


@pytest.fixture
def call(monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """Calls a script's `main` with these arguments, without the seconds that a new interpreter takes."""

    def run(main: Callable[[], None], *arguments: object) -> None:
        monkeypatch.setattr(sys, "argv", ["script", *map(str, arguments)])
        main()

    return run


# --- demonstrations


@pytest.mark.parametrize(("near", "speed"), [(0.0, 800.0), (1.0, 400.0)])
@pytest.mark.usefixtures("small_chunks")
def test_a_demonstration_repeated_succeeds_at_its_last_step(near: float, speed: float) -> None:
    """Without noise, the recorded actions are all that the environment needs."""
    recording = Recording(episodes=3, noises=(0.0,), near=near, max_speed=speed, smoothing=0.1)
    episodes = record_chunk(recording, 0)
    assert len(episodes) == 3
    for seed, episode in enumerate(episodes, start=recording.seed):
        env = PushTEnv()
        options = demonstrations._start(recording, seed)
        assert bool(options) == bool(near)
        observation, info = env.reset(seed=seed, options=options)
        for t, action in enumerate(episode["action"]):
            assert not info["is_success"]
            assert np.allclose(observation["agent_pos"], episode["observation.state"][t], atol=1e-3)
            assert np.allclose(observation["environment_state"], episode["observation.environment_state"][t], atol=1e-3)
            observation, _, _, _, info = env.step(action)
        assert info["is_success"]


@pytest.mark.usefixtures("small_chunks")
def test_a_recording_is_the_same_every_time_and_noise_is_not_recorded() -> None:
    recording = Recording(episodes=3, noises=(0.0, 5.0), max_speed=800.0, smoothing=0.1)
    first, again = record_chunk(recording, 1), record_chunk(recording, 1)
    for one, other in zip(first, again, strict=True):
        assert all(np.array_equal(one[name], other[name]) for name in one)
    episode = first[0]
    env = PushTEnv()
    env.reset(seed=recording.seed + 3)
    observation, *_ = env.step(episode["action"][0])
    assert not np.allclose(observation["agent_pos"], episode["observation.state"][1], atol=0.1)


@pytest.mark.usefixtures("small_chunks")
def test_pictures_and_keypoints_show_the_same_state() -> None:
    pytest.importorskip("pygame")
    usual = {"episodes": 3, "max_speed": 800.0, "smoothing": 0.1, "horizon": 300}
    both = record_chunk(Recording(observations=("keypoints", "pixels"), **usual), 0)[0]
    plain = record_chunk(Recording(**usual), 0)[0]
    assert all(np.array_equal(both[name], plain[name]) for name in plain)
    seen = PushTEnv(obs_type="pixels").reset(seed=100_000)[0]
    assert np.array_equal(both["observation.image"][0], seen)
    assert both["observation.image"].shape == (len(plain["action"]), 96, 96, 3)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"episodes": 0}, "episodes must be 1 or more, not 0"),
        ({"seed": 999}, "seed must leave out 0 to 999 and 20000 to 20999"),
        ({"seed": 18_500}, "seed must leave out 0 to 999 and 20000 to 20999"),
        ({"seed": -10_000}, "seed must leave out"),
        ({"noises": (-1.0,)}, "noises must be one or more numbers >= 0"),
        ({"near": 1.5}, "near must be a share between 0 and 1, not 1.5"),
        ({"max_speed": 0.0}, "max_speed must be positive, not 0.0"),
        ({"observations": ("sound",)}, "observations must be some of keypoints, pixels"),
    ],
)
def test_a_recording_that_makes_no_sense_is_an_error(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(ComparisonError, match=re.escape(message)):
        Recording(**arguments)


# --- windows


def test_windows_stay_in_their_episode() -> None:
    frames = Frames(
        columns={"action": np.arange(7.0), "observation.state": 10.0 * np.arange(7.0)},
        first=np.array([0, 0, 0, 3, 3, 3, 3]),
        last=np.array([2, 2, 2, 6, 6, 6, 6]),
        statistics={},
        features={},
    )
    values, padded = frames.windows(np.array([0, 1, 5]), {"action": [-1, 0, 1, 2], "observation.state": [-1, 0]})
    assert np.array_equal(values["action"], [[0, 0, 1, 2], [0, 1, 2, 2], [4, 5, 6, 6]])
    assert np.array_equal(padded["action"], [[1, 0, 0, 0], [0, 0, 0, 1], [0, 0, 0, 1]])
    assert np.array_equal(values["observation.state"], [[0, 0], [0, 10], [40, 50]])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"steps": 0}, "steps must be 1 or more, not 0"),
        ({"observation": "sound"}, "unknown observation 'sound'; valid: keypoints, pixels"),
        ({"action_steps": 16}, "action_steps must be at most 15, not 16"),
        ({"horizon": 12}, "horizon must be a multiple of 8, 2 for each of down_dims, not 12"),
        ({"normalization": "MIN_MAX"}, "shift needs normalization MEAN_STD: take shift 0, not 2.0"),
        ({"prediction": "x"}, "unknown prediction 'x'; valid: sample, epsilon"),
    ],
)
def test_a_training_that_makes_no_sense_is_an_error(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(ComparisonError, match=re.escape(message)):
        Training(**{"steps": 10} | arguments)


# --- bad input


@pytest.mark.usefixtures("no_lerobot")
@pytest.mark.parametrize(
    ("main", "arguments"),
    [
        (collect_demos.main, ("--out", "demos")),
        (train_diffusion.main, ("--data", "demos", "--out", "policy")),
        (compare.main, ("--task", "pusht", "--policies", "diffusion", "--diffusion-path", ".", "--out", "run")),
        (compare.main, ("--task", "pusht", "--policies", "diffusion", "--diffusion-path", "a/b", "--out", "run")),
    ],
)
def test_without_lerobot_an_error_says_how_to_get_it(
    main: Callable[[], None],
    arguments: tuple[str, ...],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    call: Callable[..., None],
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit, match="2"):
        call(main, *arguments)
    assert re.search(r"make lerobot-env.*\n?.*aicon-torch\[lerobot\]", capsys.readouterr().err)
    assert callable(factory("pusht", "aicon"))  # the others do not need it


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--task", "pusht", "--policies", "diffusion"), "--diffusion-path FOLDER belong together; train one"),
        (("--task", "pusht", "--policies", "aicon", "--diffusion-path", "x"), "--diffusion-path FOLDER belong"),
        (("--task", "nav2d", "--policies", "diffusion", "--diffusion-path", "x"), "compare them with --task pusht"),
        (("--task", "pusht", "--policies", "diffusion", "--diffusion-path", "x"), "there is no folder x"),
    ],
)
def test_a_comparison_that_makes_no_sense_is_an_error(
    arguments: tuple[str, ...], message: str, tmp_path: Path, call: Callable[..., None], capsys: Any
) -> None:
    with pytest.raises(SystemExit, match="2"):
        call(compare.main, *arguments, "--out", tmp_path / "run")
    assert message in capsys.readouterr().err
    assert not (tmp_path / "run").exists()


def test_a_hub_that_does_not_answer_is_noticed_at_once() -> None:
    start = time.monotonic()
    assert "http://127.0.0.1:9 does not answer" in hub._unreachable("http://127.0.0.1:9")
    assert time.monotonic() - start < 5.0
