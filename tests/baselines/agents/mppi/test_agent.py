"""The planner as a policy."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
import torch

pytest.importorskip("pytorch_mppi")
pytest.importorskip("pymunk")

from aicon_baselines.agents.mppi import Agent, Options
from aicon_baselines.evaluation import ComparisonError
from aicon_baselines.tasks import load
from aicon_torch.models import pusht

SMALL = Options(samples=32, horizon=10)
SEEDS = [1000, 1001, 1002]
TASK = load("pusht")
START = TASK.reset_arguments([TASK.episode(seed) for seed in SEEDS])


@pytest.fixture
def env() -> Iterator[Any]:
    """Three worlds."""
    env = TASK.make_env(len(SEEDS), "deterministic", 300)
    yield env
    env.close()


@pytest.fixture
def readings(env: Any) -> dict[str, np.ndarray]:
    """What three robots see at first."""
    observation: dict[str, np.ndarray] = env.reset(**START)[0]
    return observation


def test_a_batch_plans_what_its_rows_plan_alone(readings: dict[str, np.ndarray]) -> None:
    together, memory = Agent(SMALL).predict(readings)
    following, _ = Agent(SMALL).predict(readings, memory)
    assert together.shape == (3, 2)

    for row in range(3):
        one = {name: reading[row : row + 1] for name, reading in readings.items()}
        alone, memory = Agent(SMALL).predict(one)
        assert np.allclose(alone, together[row : row + 1], atol=1e-6)

        alone, _ = Agent(SMALL).predict(one, memory)
        assert np.allclose(alone, following[row : row + 1], atol=1e-6)


def test_samples_are_those_of_the_seed(readings: dict[str, np.ndarray]) -> None:
    torch.manual_seed(1)
    before = torch.get_rng_state()
    action, _ = Agent(SMALL, seed=3).predict(readings)
    assert torch.equal(torch.get_rng_state(), before)  # those of others go on as they would

    torch.manual_seed(2)
    assert np.array_equal(Agent(SMALL, seed=3).predict(readings)[0], action)
    assert not np.array_equal(Agent(SMALL, seed=4).predict(readings)[0], action)


def test_where_an_episode_begins_the_plan_is_forgotten(readings: dict[str, np.ndarray]) -> None:
    agent = Agent(SMALL)
    action, memory = agent.predict(readings)
    stale = memory._replace(
        plan=memory.plan + 1.0,
        pusher=memory.pusher + 0.1,
        random_state=torch.Generator().manual_seed(0).get_state(),
    )

    starts = np.array([True, False, True])
    again, _ = agent.predict(readings, stale, starts)
    assert np.allclose(again[starts], action[starts], atol=1e-9)
    assert not np.allclose(again[1], action[1], atol=1e-3)


def test_an_episode_that_begins_again_as_it_had_begun_keeps_its_plan(
    readings: dict[str, np.ndarray],
) -> None:
    agent = Agent(SMALL)
    first, memory = agent.predict(readings)
    again, kept = agent.predict(readings, memory, np.array([True, True, False]))
    assert np.array_equal(again[:2], first[:2]) and not np.allclose(again[2], first[2])

    # It costs nothing: no samples are drawn where nothing is planned.
    _, kept = agent.predict(readings, memory, np.ones(3, np.bool_))
    assert torch.equal(kept.random_state, memory.random_state)


def test_it_goes_to_the_object_and_pushes_it_towards_the_goal(env: Any) -> None:
    agent, memory = Agent(SMALL), None
    observation, info = env.reset(**START)
    first = info["distance"].copy()

    for _ in range(30):
        action, memory = agent.predict(observation, memory)
        assert (action >= 0).all() and (action <= 512).all()
        observation, _, _, _, info = env.step(action)
    assert info["distance"].mean() < 0.7 * first.mean()


@pytest.mark.slow  # torch.compile
@pytest.mark.filterwarnings("ignore::DeprecationWarning")  # torch on its own future
def test_compiled_it_plans_the_same(readings: dict[str, np.ndarray]) -> None:
    options = Options(samples=8, horizon=2)
    expected, _ = Agent(options).predict(readings)
    assert np.allclose(Agent(options).compile().predict(readings)[0], expected, atol=1e-6)


@pytest.mark.parametrize("told", [{"observe_goal": True}, {"delay": 3}])
def test_what_it_cannot_do_is_an_error(told: dict[str, Any]) -> None:
    with pytest.raises(ComparisonError, match="fixed goal .* without delay: choose other cond"):
        Agent(SMALL, pusht.Options(**told))


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_missing_reading_is_an_error(value: float, readings: dict[str, np.ndarray]) -> None:
    missing = readings | {"agent_pos": np.full((3, 2), value)}
    with pytest.raises(ComparisonError, match="agent_pos has missing values"):
        Agent(SMALL).predict(missing)
