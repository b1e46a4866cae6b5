"""Networks and hyperparameters."""

from typing import Any

import stable_baselines3
import torch
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.vec_env import VecEnv

from aicon_baselines.agents.sb3.readings import Readings
from aicon_baselines.agents.sb3.settings import Settings


def make_algorithm(config: Settings, envs: VecEnv) -> BaseAlgorithm:
    """Build what is trained, on the CPU; what is not named here is stable-baselines3's default."""
    network: dict[str, Any] = {
        "features_extractor_class": Readings,
        "net_arch": [256, 256],
        "activation_fn": torch.nn.ReLU,
    }
    common: dict[str, Any] = {"gamma": config.discount, "seed": config.seed, "device": "cpu"}
    if config.algorithm == "ppo":
        return stable_baselines3.PPO(
            "MultiInputPolicy",
            envs,
            n_steps=config.rollout,
            batch_size=min(256, config.rollout * config.envs),
            n_epochs=config.epochs,
            policy_kwargs=network | {"log_std_init": -0.5},  # σ = 0.6 of a half range; 1 would often be clipped
            **common,
        )
    return stable_baselines3.SAC(
        "MultiInputPolicy",
        envs,
        buffer_size=min(300_000, config.steps),
        learning_starts=min(5000, config.steps // 4),
        gradient_steps=max(1, config.envs // 2),  # an update for every two steps
        policy_kwargs=network,
        **common,
    )
