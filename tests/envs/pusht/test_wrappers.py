"""Properties of the imperfect sensors."""

import math
from functools import partial
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from _pusht_env import APART, random_actions
from numpy.typing import NDArray

import aicon_envs  # noqa: F401  (registers the environments)
from aicon_envs.pusht import PushTEnv
from aicon_envs.pusht.wrappers import Delay, Dropout, SensorNoise

KEYPOINTS = "environment_state"
STEPS = 30


def noise_in_dropout_delayed(env: Any) -> Any:
    return Delay(SensorNoise(Dropout(env, 0.3), 2.0), 2)


def delayed_noise_with_dropout(env: Any) -> Any:
    return Dropout(Delay(SensorNoise(env, 2.0), 2), 0.3)


WRAPPERS: dict[str, Any] = {
    "noise": partial(SensorNoise, sigma=2.0),
    "dropout": partial(Dropout, probability=0.5),
    "delay": partial(Delay, steps=3),
    "all": noise_in_dropout_delayed,
    "all in another order": delayed_noise_with_dropout,
}
every_wrapper = pytest.mark.parametrize("wrap", WRAPPERS.values(), ids=WRAPPERS)


def observations(env: Any, steps: int = STEPS, **reset: Any) -> list[dict[str, Any]]:
    record = [env.reset(**reset)[0]]
    record += [env.step(action)[0] for action in random_actions(steps)]
    return record


def stacked(record: list[dict[str, Any]], key: str = KEYPOINTS) -> NDArray[np.float64]:
    return np.array([observation[key] for observation in record])


@every_wrapper
def test_observations_lie_in_the_wrapped_space(wrap: Any) -> None:
    env = wrap(PushTEnv())
    assert all(observation in env.observation_space for observation in observations(env, seed=0))


@every_wrapper
def test_same_seed_gives_the_same_readings(wrap: Any) -> None:
    first, second = wrap(PushTEnv()), wrap(PushTEnv())
    observations(second, seed=9)

    resets: list[Any] = [{"seed": 1}, {}, {"seed": 1, "options": {"noise_seed": 2}}]
    for reset in resets:
        expected = stacked(observations(first, **reset))
        np.testing.assert_array_equal(expected, stacked(observations(second, **reset)))


@pytest.mark.parametrize("wrap", [WRAPPERS["noise"], WRAPPERS["dropout"]])
def test_another_seed_or_noise_seed_gives_other_readings(wrap: Any) -> None:
    env = wrap(PushTEnv())
    state = {"reset_to_state": APART}
    resets: list[Any] = [
        {"seed": 1, "options": state | {"noise_seed": 0}},
        {"seed": 1, "options": state | {"noise_seed": 1}},
        {"seed": 1, "options": state},
        {"seed": 2, "options": state},
        {"options": state},
    ]

    readings = {stacked(observations(env, **reset)).tobytes() for reset in resets}
    assert len(readings) == len(resets)


@every_wrapper
def test_the_world_is_that_of_the_environment_alone(wrap: Any) -> None:
    arguments: Any = {"action_noise": 2.0, "kick_interval": 5}
    plain, wrapped = PushTEnv(**arguments), wrap(PushTEnv(**arguments))
    plain.reset(seed=3)
    wrapped.reset(seed=3)

    for action in random_actions(20):
        _, *expected, expected_info = plain.step(action)
        _, *results, info = wrapped.step(action)
        np.testing.assert_array_equal(expected_info["block_pose"], info["block_pose"])
        assert expected == results


def test_noise_has_the_stated_size() -> None:
    record = observations(SensorNoise(PushTEnv(), 3.0), 400, seed=0)
    truth = observations(PushTEnv(), 400, seed=0)

    errors = stacked(record) - stacked(truth)
    np.testing.assert_allclose(errors.std(axis=0), 3.0, rtol=0.15)
    np.testing.assert_allclose(errors.mean(axis=0), 0.0, atol=0.6)
    assert abs(np.corrcoef(errors[1:, 0], errors[:-1, 0])[0, 1]) < 0.15

    positions = stacked(record, "agent_pos") - stacked(truth, "agent_pos")
    np.testing.assert_array_equal(positions, 0.0)


@pytest.mark.parametrize("probability", [0.0, 0.3, 1.0])
def test_dropout_loses_whole_readings_with_its_probability_and_never_the_first(
    probability: float,
) -> None:
    record = observations(Dropout(PushTEnv(), probability), 400, seed=0)
    truth = observations(PushTEnv(), 400, seed=0)

    missing = np.isnan(stacked(record))
    lost = missing.any(axis=1)
    assert (missing.all(axis=1) == lost).all() and not lost[0]
    assert lost[1:].mean() == pytest.approx(probability, abs=0.07)
    assert not np.isnan(stacked(record, "agent_pos")).any()
    np.testing.assert_array_equal(stacked(record)[~lost], stacked(truth)[~lost])


@pytest.mark.parametrize("steps", [0, 1, 4])
@pytest.mark.parametrize("obs_type", ["environment_state_agent_pos", "state"])
def test_delay_repeats_the_first_observation_and_then_lags(steps: int, obs_type: Any) -> None:
    env = Delay(PushTEnv(obs_type=obs_type), steps)

    for seed in (0, 1):
        delayed = observations(env, seed=seed)
        prompt = observations(PushTEnv(obs_type=obs_type), seed=seed)
        for index, observation in enumerate(delayed):
            np.testing.assert_equal(observation, prompt[max(index - steps, 0)])


def test_two_noises_are_independent() -> None:
    once, twice = SensorNoise(PushTEnv(), 2.0), SensorNoise(SensorNoise(PushTEnv(), 2.0), 2.0)
    truth = stacked(observations(PushTEnv(), seed=0))

    inner = stacked(observations(once, seed=0)) - truth
    both = stacked(observations(twice, seed=0)) - truth
    assert abs(np.corrcoef(inner.ravel(), (both - inner).ravel())[0, 1]) < 0.2


def test_specs_make_the_wrapped_environment_again() -> None:
    plain = gym.make("aicon/PushT-v0", object="L")
    env = Delay(Dropout(SensorNoise(plain, 2.0), 0.2), 3)
    assert env.spec is not None

    again = gym.make(env.spec)
    expected = stacked(observations(env, seed=0))
    np.testing.assert_array_equal(expected, stacked(observations(again, seed=0)))


@pytest.mark.parametrize(
    ("wrapper", "arguments", "word"),
    [
        (SensorNoise, {"sigma": -1.0}, "sigma"),
        (SensorNoise, {"sigma": math.nan}, "sigma"),
        (Dropout, {"probability": 1.5}, "probability"),
        (Dropout, {"probability": math.nan}, "probability"),
        (Dropout, {"probability": "often"}, "probability"),
        (Delay, {"steps": -1}, "steps"),
        (Delay, {"steps": 1.5}, "steps"),
    ],
)
def test_bad_arguments(wrapper: Any, arguments: dict[str, Any], word: str) -> None:
    with pytest.raises(ValueError, match=word):
        wrapper(PushTEnv(), **arguments)


@pytest.mark.parametrize("wrap", [WRAPPERS["noise"], WRAPPERS["dropout"]])
@pytest.mark.parametrize("obs_type", ["state", "pixels_agent_pos"])
def test_keypoints_are_needed(wrap: Any, obs_type: Any) -> None:
    with pytest.raises(ValueError, match="environment_state_agent_pos"):
        wrap(PushTEnv(obs_type=obs_type))


def test_the_environment_is_one_of_pusht() -> None:
    with pytest.raises(ValueError, match="the environment must be one of pushT, got"):
        Delay(gym.make("aicon/Nav2D-v0"), 2)
