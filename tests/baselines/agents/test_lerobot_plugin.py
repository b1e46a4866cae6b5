"""AICON inside LeRobot: its evaluator, on gym-pusht."""

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


@pytest.fixture
def policy() -> Any:
    config = PreTrainedConfig.get_choice_class("aicon")(device="cpu")
    return make_lerobot_policy(config, env_cfg=PushtEnv(obs_type=KEYPOINTS))


def test_the_distribution_registers_the_policy(policy: Any) -> None:
    assert "aicon" in PreTrainedConfig.get_known_choices()
    assert isinstance(policy, lerobot_policy_aicon.AiconPolicy)
    assert policy.config.type == "aicon"


def test_it_is_the_policy_of_the_library(policy: Any) -> None:
    env = gym.make("gym_pusht:gym_pusht/PushT-v0", obs_type=KEYPOINTS, disable_env_checker=True)
    reference, memory = make_policy("pusht"), None
    observation, _ = env.reset(seed=1000)
    for _ in range(20):
        seen = {name: torch.from_numpy(value[None]) for name, value in observation.items()}
        with torch.inference_mode():  # as LeRobot does
            action = policy.select_action(
                {
                    "observation.environment_state": seen["environment_state"].clone(),
                    "observation.state": seen["agent_pos"].clone(),
                }
            )
        expected, memory = reference.predict(observation, memory)
        assert action.dtype == torch.float32 and np.allclose(action[0].numpy(), expected, atol=1e-4)
        observation, *_ = env.step(expected)
    env.close()


def test_lerobots_rollout_succeeds(policy: Any) -> None:
    settings = PushtEnv(obs_type=KEYPOINTS)
    envs = make_env(settings, n_envs=3)["pusht"][0]
    before, after = make_pre_post_processors(policy.config)
    for seeds in ([1000, 1001, 1002], [1003, 1004, 1005]):
        result = rollout(envs, policy, same, same, before, after, seeds=seeds)
        assert result["success"].any(dim=1).all()
    envs.close()


def same(transition: Any) -> Any:
    return transition


def test_what_it_cannot_observe_is_an_error() -> None:
    config = PreTrainedConfig.get_choice_class("aicon")(device="cpu")
    with pytest.raises(ValueError, match=f"--env.obs_type={KEYPOINTS}"):
        make_lerobot_policy(config, env_cfg=PushtEnv(obs_type="pixels_agent_pos"))


def test_there_is_nothing_to_train(policy: Any) -> None:
    with pytest.raises(NotImplementedError, match="not trained"):
        policy.config.get_optimizer_preset()
    with pytest.raises(NotImplementedError, match="not trained"):
        policy.forward({})
