import re
from typing import Any

import numpy as np
import pytest

pytest.importorskip("pymunk")

from aicon_baselines.agents.diffusion import demonstrations
from aicon_baselines.agents.diffusion.configs import RecordingConfig
from aicon_baselines.agents.diffusion.demonstrations import record_chunk, reset_options
from aicon_baselines.evaluation import ComparisonError
from aicon_envs.pusht import PushTEnv

QUICK: dict[str, Any] = {"episodes": 3, "max_speed": 800.0, "smoothing": 0.02}


@pytest.fixture(autouse=True)
def small_chunks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(demonstrations, "CHUNK_SIZE", 3)


@pytest.mark.parametrize(
    ("near", "speed"),
    [(0.0, 800.0), (1.0, 800.0), pytest.param(1.0, 400.0, marks=pytest.mark.slow)],
)
def test_a_demonstration_repeated_succeeds_at_its_last_step(near: float, speed: float) -> None:
    """Without noise, the recorded actions are all that the environment needs."""
    config = RecordingConfig(**QUICK | {"noises": (0.0,), "near": near, "max_speed": speed})
    episodes = record_chunk(config, 0)
    assert len(episodes) == 3

    for seed, episode in enumerate(episodes, start=config.seed):
        options = reset_options(seed, near)
        assert bool(options) == bool(near)

        env = PushTEnv()
        observation, info = env.reset(seed=seed, options=options)
        for t, action in enumerate(episode["action"]):
            assert not info["is_success"]
            pusher, keypoints = observation["agent_pos"], observation["environment_state"]
            assert np.allclose(pusher, episode["observation.state"][t], atol=1e-3)
            assert np.allclose(keypoints, episode["observation.environment_state"][t], atol=1e-3)
            observation, _, _, _, info = env.step(action)
        assert info["is_success"]


def test_a_recording_is_the_same_every_time_and_noise_is_not_recorded() -> None:
    config = RecordingConfig(**QUICK, noises=(0.0, 5.0))
    episodes, repeated = record_chunk(config, 1), record_chunk(config, 1)
    for episode, again in zip(episodes, repeated, strict=True):
        for name in episode:
            assert np.array_equal(episode[name], again[name])

    env = PushTEnv()
    env.reset(seed=config.seed + 3)
    observation, *_ = env.step(episodes[0]["action"][0])
    recorded = episodes[0]["observation.state"][1]
    assert not np.allclose(observation["agent_pos"], recorded, atol=0.1)


def test_pictures_and_keypoints_show_the_same_state() -> None:
    pytest.importorskip("pygame")
    both = record_chunk(RecordingConfig(**QUICK, observations=("keypoints", "pixels")), 0)[0]
    without_pictures = record_chunk(RecordingConfig(**QUICK), 0)[0]

    for name, values in without_pictures.items():
        assert np.array_equal(both[name], values)

    first_picture = PushTEnv(obs_type="pixels").reset(seed=100_000)[0]
    assert np.array_equal(both["observation.image"][0], first_picture)
    assert both["observation.image"].shape == (len(both["action"]), 96, 96, 3)


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
def test_a_recording_that_makes_no_sense_is_an_error(
    arguments: dict[str, Any], message: str
) -> None:
    with pytest.raises(ComparisonError, match=re.escape(message)):
        RecordingConfig(**arguments)
