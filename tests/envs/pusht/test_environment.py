"""The environment's contract: spaces, optional packages, and errors that name the argument."""

import math
import subprocess
import sys
import warnings
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from _pusht_env import DISTURBED, ID, OBS_TYPES, random_actions
from gymnasium.utils.env_checker import check_env

import aicon_envs  # noqa: F401  (registers the environments)
from aicon_envs.pusht import OBJECTS, PushTEnv

# --- the contracts of Gymnasium and stable-baselines3


def assert_only_advice_on_scaling(check: Any, env: Any) -> None:
    """Targets in px are not normalised, as in gym-pusht; every other warning is an error.

    The starts are always the same: a few in a thousand put a corner beyond the bounds of the space.
    """
    env.np_random = np.random.default_rng(0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", message=".*symmetric and normalized")
        check(env)


@pytest.mark.parametrize("obs_type", OBS_TYPES)
def test_gymnasium_accepts_it_without_a_warning(obs_type: Any) -> None:
    env = gym.make(ID, obs_type=obs_type, render_mode="rgb_array", visualization_width=64)
    assert_only_advice_on_scaling(check_env, env.unwrapped)


@pytest.mark.parametrize("obs_type", OBS_TYPES)
def test_stable_baselines3_accepts_it_without_a_warning(obs_type: Any) -> None:
    checker = pytest.importorskip("stable_baselines3.common.env_checker")
    size: Any = {"visualization_width": 64, "visualization_height": 64}
    env = gym.make(ID, obs_type=obs_type, render_mode="rgb_array", **size)
    assert_only_advice_on_scaling(checker.check_env, env.unwrapped)


@pytest.mark.parametrize("object", OBJECTS)
def test_observations_of_a_disturbed_task_stay_in_their_space(object: str) -> None:
    env = PushTEnv(object=object, velocity_limit=900.0, **DISTURBED)
    observation, _ = env.reset(seed=1)

    for action in random_actions(60, seed=2):
        assert observation in env.observation_space
        observation, reward, _, _, info = env.step(action)
        assert 0.0 <= reward <= 1.0
        assert info["goal_pose"] == pytest.approx(observation["goal_pose"])


def test_registered_limit_and_default_observation() -> None:
    assert gym.spec(ID).max_episode_steps == 300
    space = gym.make(ID).observation_space
    assert isinstance(space, gym.spaces.Dict)
    assert set(space) == {"environment_state", "agent_pos"}


def test_step_before_reset_is_an_error() -> None:
    with pytest.raises(gym.error.ResetNeeded):
        PushTEnv().step(np.zeros(2, np.float32))


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_the_action_is_left_as_it_was(dtype: Any) -> None:
    env = PushTEnv()
    env.reset(seed=0)

    action = np.array([0.9, 510.0], dtype=dtype)
    env.step(action)
    np.testing.assert_array_equal(action, np.array([0.9, 510.0], dtype=dtype))


# --- optional packages


@pytest.mark.parametrize(
    ("missing", "code"),
    [
        ("pymunk", 'gym.make("aicon/PushT-v0")'),
        ("pygame", 'gym.make("aicon/PushT-v0", obs_type="pixels").reset()'),
    ],
)
def test_a_missing_extra_is_named(missing: str, code: str) -> None:
    hide = f"import sys; sys.modules[{missing!r}] = None; "
    imports = "import gymnasium as gym; import aicon_envs; "
    command = [sys.executable, "-c", hide + imports + code]

    result = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
    assert 'pip install "aicon-torch[pusht]"' in result.stderr, result.stderr


def test_without_pictures_nothing_needs_pygame() -> None:
    hide = "import sys; sys.modules['pygame'] = sys.modules['cv2'] = None; "
    imports = "import gymnasium as gym; import aicon_envs; "
    play = (
        "env = gym.make('aicon/PushT-v0'); env.reset(seed=0); env.step(env.action_space.sample())"
    )
    subprocess.run([sys.executable, "-c", hide + imports + play], check=True, timeout=300)


# --- errors name the argument


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"obs_type": "keypoints"}, ["obs_type", "environment_state_agent_pos", "pixels"]),
        (
            {"obs_type": "state", "observe_goal": True},
            ["observe_goal", "environment_state_agent_pos"],
        ),
        ({"render_mode": "human"}, ["render_mode", "rgb_array"]),
        ({"object": "W"}, ["object", "quadrilateral", "vertices"]),
        ({"object": [(0, 0), (1, 1)]}, ["polygon"]),
        ({"goal_pose": (1, 2)}, ["goal_pose", "rad"]),
        ({"goal_pose": (600, 2, 0)}, ["goal_pose", "512"]),
        ({"goal_pose": "anywhere"}, ["goal_pose"]),
        ({"action_noise": -1.0}, ["action_noise", ">= 0"]),
        ({"action_noise": "much"}, ["action_noise"]),
        ({"velocity_limit": 0.0}, ["velocity_limit", "> 0"]),
        ({"velocity_limit": math.inf}, ["velocity_limit"]),
        ({"goal_jumps": -1}, ["goal_jumps"]),
        ({"kick_interval": 0}, ["kick_interval", ">= 1"]),
        ({"observation_width": 0}, ["observation_width"]),
        ({"visualization_height": 1.5}, ["visualization_height"]),
    ],
)
def test_bad_arguments(arguments: dict[str, Any], words: list[str]) -> None:
    with pytest.raises(ValueError) as error:
        PushTEnv(**arguments)
    assert all(word in str(error.value) for word in words), str(error.value)


def test_unknown_argument_lists_the_valid_ones() -> None:
    with pytest.raises(
        TypeError, match="acton_noise; .* are obs_type, render_mode, .*action_noise"
    ):
        PushTEnv(acton_noise=0.1)  # type: ignore[call-arg]


@pytest.mark.parametrize("action", [[math.nan, 0.0], [math.inf, 0.0], [0.0], [[0.0, 0.0]], 0.0])
def test_bad_action(action: Any) -> None:
    env = PushTEnv()
    env.reset(seed=0)
    with pytest.raises(ValueError, match="action"):
        env.step(np.array(action, dtype=np.float32))
