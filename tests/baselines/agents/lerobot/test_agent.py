import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

pytest.importorskip("lerobot")

from lerobot.envs.utils import preprocess_observation
from lerobot.policies.diffusion.modeling_diffusion import DiffusionPolicy
from lerobot.policies.factory import make_pre_post_processors

from aicon_baselines.agents.diffusion.agent import Agent, sample_generator
from aicon_baselines.agents.diffusion.configs import TrainingConfig
from aicon_baselines.agents.diffusion.training import train
from aicon_baselines.evaluation import ComparisonError
from aicon_baselines.tasks import load as load_task

Observations = list[dict[str, np.ndarray]]
Act = Callable[..., np.ndarray]


def test_an_agent_acts_as_lerobot_does(policy: Path, observations: Observations) -> None:
    """The same checkpoint and noise: LeRobot's own loading, queues and processors."""
    agent = Agent(policy, "DDIM", 5)
    reference = DiffusionPolicy.from_pretrained(
        policy, cli_overrides=["--noise_scheduler_type=DDIM", "--num_inference_steps=5"]
    )
    preprocess, postprocess = make_pre_post_processors(
        reference.config, pretrained_path=str(policy)
    )

    memory: Any = None
    for observation in observations:
        action, memory = agent.predict(observation, memory, np.zeros(4, np.bool_))

        noise = []
        last_samples = memory["samples"] - 1
        for episode, sample in zip(memory["episode_seed"], last_samples, strict=True):
            generator = sample_generator(int(episode), int(sample))
            noise.append(torch.randn(16, 2, generator=generator))
        batch = preprocess(preprocess_observation(observation))
        expected = postprocess(reference.select_action(batch, noise=torch.stack(noise)))
        assert np.allclose(action, expected.numpy(), atol=1e-3)


@pytest.mark.parametrize("sampler", ["DDPM", "DDIM"])
def test_rows_are_separate_robots(
    policy: Path, observations: Observations, sampler: str, act: Act
) -> None:
    agent = Agent(policy, sampler, 5)
    starts = {3: [1], 7: [0, 2], 8: [2]}
    together = act(agent, observations, starts)
    assert together.shape == (12, 4, 2)

    for row in range(4):
        alone = [
            {name: value[row : row + 1] for name, value in observation.items()}
            for observation in observations
        ]
        begins = {t: [0] for t, rows in starts.items() if row in rows}
        # A batch of another size is rounded otherwise, by how much depends on the processor.
        assert np.allclose(act(agent, alone, begins)[:, 0], together[:, row], atol=0.1)
        assert not np.allclose(together[:, row - 1], together[:, row], atol=1.0)

    mirrored = [
        {name: value[::-1] for name, value in observation.items()} for observation in observations
    ]
    mirrored_starts = {t: [3 - row for row in rows] for t, rows in starts.items()}
    actions = act(agent, mirrored, mirrored_starts)
    assert np.allclose(actions[:, ::-1], together, atol=1e-2)


def test_an_episode_depends_on_its_start_and_the_seed_alone(
    policy: Path, observations: Observations, act: Act
) -> None:
    agent, other = Agent(policy, "DDPM", 5), Agent(policy, "DDPM", 5, seed=1)
    actions = act(agent, observations)

    torch.manual_seed(5)
    assert np.array_equal(act(agent, observations), actions)
    assert not np.allclose(act(other, observations), actions, atol=1.0)

    # An episode that begins in the middle goes as if it had begun at first.
    begun_late = act(agent, observations, {4: [0, 1, 2, 3]})[4:]
    assert np.allclose(act(agent, observations[4:]), begun_late, atol=1e-2)


def test_an_episode_that_ended_is_not_sampled_again(
    policy: Path, observations: Observations, monkeypatch: pytest.MonkeyPatch, act: Act
) -> None:
    """In a comparison it stays in the batch unchanged, and begins anew at every step."""
    agent = Agent(policy, "DDIM", 2)
    sample, sampled_rows = agent._sample, []

    def count_rows(memory: Any, rows: Any, generators: Any) -> Any:
        sampled_rows.append(len(rows))
        return sample(memory, rows, generators)

    monkeypatch.setattr(agent, "_sample", count_rows)
    actions = act(agent, observations[:1] * 6, {t: [0, 1, 2, 3] for t in range(6)})

    assert sampled_rows == [4]
    for action in actions:
        assert np.array_equal(action, actions[0])


def test_what_an_agent_is_given_stays_as_it_is(policy: Path, observations: Observations) -> None:
    """The memory and the starts are arguments, also where it keeps what it sampled."""
    agent = Agent(policy, "DDIM", 2)
    starts = np.ones(4, np.bool_)
    _, memory = agent.predict(observations[0])
    before = {name: value.clone() for name, value in memory.items()}

    agent.predict(observations[0], memory, starts)

    assert starts.all()
    for name, value in before.items():
        assert torch.equal(memory[name], value)


def test_stochastic_actions_differ(policy: Path, observations: Observations) -> None:
    agent = Agent(policy, "DDIM", 2)
    first, _ = agent.predict(observations[0], deterministic=False)
    second, _ = agent.predict(observations[0], deterministic=False)
    assert not np.allclose(first, second)


def test_a_policy_that_sees_pictures_gets_them(
    demos: Path, small: dict[str, Any], tmp_path: Path
) -> None:
    train(TrainingConfig(1, observation="pixels", **small | {"batch": 2}), demos, tmp_path)
    agent = Agent(tmp_path / "policy", "DDIM", 2)
    assert agent.name.startswith("diffusion_pixels_ddim2_")

    for condition in ("deterministic", "upstream"):
        env = load_task("pusht").make_env(2, condition, 5, **agent.env_options)
        observation, _ = env.reset(seed=[1000, 1001], options={})
        assert observation["pixels"].shape == (2, 96, 96, 3)

        action, memory = agent.predict(observation)
        alone, _ = agent.predict({name: value[:1] for name, value in observation.items()})
        assert np.allclose(action[:1], alone, atol=1e-2)

        env.step(action)
        assert agent.predict(observation, memory, np.zeros(2, np.bool_))[0].shape == (2, 2)
        env.close()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"environment_state": np.zeros((4, 12))},
            "observes environment_state (16,), and this condition offers",
        ),
        ({"agent_pos": np.full((4, 2), np.nan)}, "agent_pos has missing values"),
    ],
)
def test_other_readings_are_an_error(
    change: dict[str, Any], message: str, policy: Path, observations: Observations
) -> None:
    with pytest.raises(ComparisonError, match=re.escape(message)):
        Agent(policy).predict(observations[0] | change)
