"""AICON inside LeRobot: its evaluator, on gym-pusht."""

import functools
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
import torch

pytest.importorskip("lerobot")
pytest.importorskip("gym_pusht")
pytest.importorskip("lerobot_policy_aicon")

from lerobot.configs.policies import PreTrainedConfig
from lerobot.envs.configs import PushtEnv
from lerobot.envs.factory import make_env
from lerobot.policies.factory import make_policy as make_lerobot_policy
from lerobot.policies.factory import make_pre_post_processors
from lerobot.scripts.lerobot_eval import rollout

import lerobot_policy_aicon
from aicon_torch import make_policy

KEYPOINTS = "environment_state_agent_pos"


@functools.cache
def build(**options: Any) -> Any:
    config = PreTrainedConfig.get_choice_class("aicon")(device="cpu", **options)
    return make_lerobot_policy(config, env_cfg=PushtEnv(obs_type=KEYPOINTS))


@pytest.fixture
def plugin() -> Any:
    return build()


def test_the_distribution_registers_the_policy(plugin: Any) -> None:
    assert "aicon" in PreTrainedConfig.get_known_choices()
    assert isinstance(plugin, lerobot_policy_aicon.AiconPolicy)
    assert plugin.config.type == "aicon"


@pytest.mark.parametrize(
    "options",
    [
        pytest.param({}, id="default"),
        pytest.param(
            {"preset": "paper_literal", "max_speed": 0.4},
            id="preset and max_speed",
            marks=pytest.mark.slow,
        ),
        pytest.param({"max_speed": 0.4}, id="max_speed", marks=pytest.mark.slow),
        pytest.param({"preset": "potential_field"}, id="preset", marks=pytest.mark.slow),
        pytest.param({"preset": "paper_literal"}, id="its own law", marks=pytest.mark.slow),
    ],
)
def test_it_is_the_policy_of_the_library(options: dict[str, Any]) -> None:
    env = gym.make("gym_pusht:gym_pusht/PushT-v0", obs_type=KEYPOINTS, disable_env_checker=True)
    plugin, reference, memory = build(**options), make_policy("pusht", **options), None
    plugin.reset()
    observation, _ = env.reset(seed=1000)

    for _ in range(6):  # roundings grow along a chaotic run
        batch = {
            "observation.environment_state": torch.tensor(observation["environment_state"])[None],
            "observation.state": torch.tensor(observation["agent_pos"])[None],
        }
        with torch.inference_mode():  # as LeRobot does
            action = plugin.select_action(batch)
        expected, memory = reference.predict(observation, memory)

        assert action.dtype == torch.float32
        assert np.allclose(action[0].numpy(), expected, atol=1e-4)
        observation, *_ = env.step(expected)

    env.close()


def test_lerobots_rollout_succeeds(plugin: Any) -> None:
    envs = make_env(PushtEnv(obs_type=KEYPOINTS), n_envs=3)["pusht"][0]
    preprocess, postprocess = make_pre_post_processors(plugin.config)

    for seeds in ([1000, 1001, 1002], [1003, 1004, 1005]):
        result = rollout(envs, plugin, unchanged, unchanged, preprocess, postprocess, seeds=seeds)
        assert result["success"].any(dim=1).all()

    envs.close()


def unchanged(transition: Any) -> Any:
    return transition


def test_what_it_cannot_observe_is_an_error() -> None:
    config = PreTrainedConfig.get_choice_class("aicon")(device="cpu")
    with pytest.raises(ValueError, match=f"--env.obs_type={KEYPOINTS}"):
        make_lerobot_policy(config, env_cfg=PushtEnv(obs_type="pixels_agent_pos"))


def test_there_is_nothing_to_train(plugin: Any) -> None:
    with pytest.raises(NotImplementedError, match="not trained"):
        plugin.config.get_optimizer_preset()
    with pytest.raises(NotImplementedError, match="not trained"):
        plugin.forward({})
