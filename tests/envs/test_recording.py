"""Gymnasium's films of our environments."""

from pathlib import Path

import gymnasium
import pytest

import aicon_envs  # noqa: F401  # it registers them

pytest.importorskip("moviepy", reason="Gymnasium's films need the extra [compare]")


@pytest.mark.filterwarnings("ignore")  # moviepy's, of what it calls
def test_gymnasium_films_an_episode(tmp_path: Path) -> None:
    plain = gymnasium.make("aicon/Nav2D-v0", render_mode="rgb_array")
    env = gymnasium.wrappers.RecordVideo(plain, str(tmp_path), disable_logger=True)
    env.reset(seed=0)
    for _ in range(3):
        env.step(env.action_space.sample())
    env.close()

    (film,) = tmp_path.glob("*.mp4")
    assert film.stat().st_size > 0
