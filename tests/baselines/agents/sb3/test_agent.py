from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

pytest.importorskip("stable_baselines3")
pytest.importorskip("pymunk")

from aicon_baselines.agents import sb3
from aicon_baselines.agents.registry import saved_agent
from aicon_baselines.agents.sb3.environments import make_training_envs
from aicon_baselines.agents.sb3.statistics import load_statistics
from aicon_baselines.agents.sb3.weights import load_trusted_algorithm
from aicon_baselines.agents.sb3.wrappers import LAST_ACTION, OFFSETS, target_of_action
from aicon_baselines.evaluation import ComparisonError
from aicon_baselines.tasks import load

Folders = dict[tuple[str, str], Path]


@pytest.fixture
def readings() -> dict[str, np.ndarray]:
    """What 3 robots see of pushT."""
    rng = np.random.default_rng(0)
    return {
        "environment_state": rng.uniform(0, 512, (3, 16)),
        "agent_pos": rng.uniform(0, 512, (3, 2)),
    }


def test_an_agent_gets_in_a_comparison_what_it_got_in_training(
    kind: tuple[str, str], agent_folders: Folders
) -> None:
    """Actions and readings through VecNormalize, VecFrameStack and the wrappers, over episodes."""
    folder = agent_folders[kind]
    agent = sb3.Agent(folder, kind[0])
    config = agent.config

    envs = make_training_envs(config, 5000)
    normalized_envs = load_statistics(folder / "statistics.json", envs, config.discount)
    normalized_envs.training = False
    model = load_trusted_algorithm(folder / "agent.zip", config)
    seen = normalized_envs.reset()

    memory: Any = None
    start = np.ones(2, np.bool_)
    for _ in range(config.horizon + 15):
        offered: Any = envs.unwrapped.buf_obs
        names = [name for name in offered if name not in (LAST_ACTION, OFFSETS)]
        readings = {name: offered[name].copy() for name in names}

        expected, _ = model.predict(seen, deterministic=True)
        action, memory = agent.predict(readings, memory, start)
        command = expected
        if config.reach is not None:
            command = target_of_action(expected, readings, config.reach)
        assert np.allclose(action, command, atol=1e-5 * np.abs(action).max())

        seen, _, start, _ = normalized_envs.step(expected)


@pytest.mark.parametrize("missing", [np.nan, np.inf])
def test_a_missing_reading_keeps_its_last_value(
    missing: float, agent_folders: Folders, readings: dict[str, np.ndarray]
) -> None:
    agent = sb3.Agent(agent_folders["pusht", "ppo"], "pusht")
    keypoints = np.where(np.arange(16) < 4, missing, readings["environment_state"])
    incomplete = readings | {"environment_state": keypoints}
    goes_on = np.zeros(3, np.bool_)

    _, memory = agent.predict(readings)
    expected, _ = agent.predict(readings, memory, goes_on)
    action, _ = agent.predict(incomplete, memory, goes_on)
    assert np.array_equal(action, expected)

    first, _ = agent.predict(incomplete)
    assert np.isfinite(first).all()


def test_no_episode_begins_where_none_is_told_to(
    agent_folders: Folders, readings: dict[str, np.ndarray]
) -> None:
    agent = sb3.Agent(agent_folders["pusht", "ppo"], "pusht")
    _, memory = agent.predict(readings)
    _, (stacks, _) = agent.predict(readings, memory)
    _, (expected, _) = agent.predict(readings, memory, np.zeros(3, np.bool_))
    for name, stack in stacks.items():
        assert np.array_equal(stack, expected[name])


def test_sampled_actions_come_from_the_memory_alone(
    agent_folders: Folders, readings: dict[str, np.ndarray]
) -> None:
    folder = agent_folders["pusht", "ppo"]
    likely = sb3.Agent(folder, "pusht")
    sampled = sb3.Agent(folder, "pusht", sampled=True)

    def act_three_times(agent: sb3.Agent) -> list[Any]:
        memory, actions = None, []
        for _ in range(3):
            torch.rand(5)  # others draw numbers too
            action, memory = agent.predict(readings, memory, np.zeros(3, np.bool_))
            actions.append(action)
        return actions

    torch.manual_seed(1)
    actions, next_number = act_three_times(sampled), torch.rand(1)
    torch.manual_seed(1)
    assert np.array_equal(act_three_times(sampled), actions)
    assert torch.equal(torch.rand(1), next_number)

    assert not np.isclose(act_three_times(likely), actions).all(axis=(1, 2)).any()
    assert sampled.name == f"{likely.name}_sampled"


def test_other_readings_are_an_error(agent_folders: Folders) -> None:
    _, build = saved_agent("pusht", agent_folders["pusht", "ppo"])
    env = load("pusht").make_env(2, "object_L", 5)
    observation, _ = env.reset(seed=1000)
    message = "observes .* and this condition offers .*choose conditions"
    with pytest.raises(ComparisonError, match=message):
        build("object_L").predict(observation)
