"""The task "pusht"."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

pytest.importorskip("pymunk")

from _inputs import driven

from aicon_baselines.evaluation.rollout import rollout
from aicon_baselines.evaluation.task import Episode
from aicon_baselines.tasks import pusht
from aicon_baselines.tasks.faults import FAULTS
from aicon_baselines.tasks.pusht import TASK
from aicon_torch.models.pusht import PIXEL


@pytest.mark.parametrize("condition", ["deterministic", "noise_2", "upstream"])
def test_starts_are_those_of_gym_pusht_and_repeats_differ_in_noise(condition: str) -> None:
    gym_pusht = pytest.importorskip("gym_pusht.envs")
    upstream = gym_pusht.PushTEnv(obs_type="environment_state_agent_pos")
    ends = []
    for repeat in (0, 1):
        env = TASK.make_env(2, condition, 5)
        episodes = TASK.chunk(2, repeat)[7:9]
        observation, _ = env.reset(**TASK.reset_arguments(episodes))

        for row, episode in enumerate(episodes):
            expected, _ = upstream.reset(seed=episode.seed)
            for key, value in expected.items():
                np.testing.assert_allclose(observation[key][row], value, rtol=1e-12)

        *_, info = env.step(np.full((2, 2), 256, np.float32))
        ends.append(info["position"])
        env.close()
    assert (ends[0] == ends[1]).all() == (condition in TASK.noiseless)


def readings(condition: str, repeat: int) -> NDArray[np.float64]:
    """What is read of the object, and where the pusher is, while it is told to move around."""
    generator = np.random.default_rng(0)
    env = TASK.make_env(1, condition, 80)
    env.reset(**TASK.reset_arguments([TASK.episode(3, repeat)]))

    found = []
    for _ in range(65):
        action = generator.uniform(100.0, 400.0, (1, 2)).astype(np.float32)
        observation, *_, info = env.step(action)
        found.append(np.concatenate([observation["environment_state"], info["position"]], axis=1))
    env.close()
    return np.array(found)


@pytest.mark.parametrize("condition", [*FAULTS, "late+bias", "late+held"])
def test_repeats_of_a_fault_differ_unless_it_draws_nothing(condition: str) -> None:
    first, second = readings(condition, 0), readings(condition, 1)
    assert np.array_equal(first, second, equal_nan=True) == TASK.is_noiseless(condition)


def test_the_policy_is_told_lengths_in_metres() -> None:
    assert pusht.PIXEL == PIXEL
    assert TASK.policy_options("deterministic") == {}
    assert TASK.policy_options("half_speed") == {"max_speed": 400 * PIXEL}
    assert TASK.policy_options("delay") == {"delay": 3}
    assert TASK.policy_options("keypoint_noise") == {"keypoint_noise": 2.0 * PIXEL}
    assert TASK.policy_options("goal_jumps") == {"observe_goal": True}

    told = TASK.policy_options("object_L")
    corners = np.array(told["keypoints"])
    assert set(told) == {"keypoints", "outline_order"}
    assert 50 * PIXEL < np.ptp(corners, axis=0).max() < 300 * PIXEL
    assert sorted(told["outline_order"]) == list(range(len(corners)))


@pytest.mark.parametrize(
    ("preset", "succeeds"),
    [
        ("aicon", True),
        pytest.param("potential_field", False, marks=pytest.mark.slow),
        pytest.param("steepest", False, marks=pytest.mark.slow),
    ],
)
def test_aicon_pushes_the_t_in_place_where_sum_and_steepest_path_do_not(
    preset: str, succeeds: bool
) -> None:
    """Whole episodes, within 60 steps."""
    seeds = (1000, 1016, 1022)
    episodes = [Episode(seed, 0, "uniform") for seed in seeds]
    task = replace(TASK, horizon=60)
    outcome = rollout(driven("pusht", preset=preset), task, "deterministic", episodes, seeds)
    assert outcome.success.tolist() == [succeeds] * 3
