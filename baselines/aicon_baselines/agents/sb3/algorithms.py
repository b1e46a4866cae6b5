"""Networks and hyperparameters, and how readings enter the network."""

from typing import Any

import numpy as np
import stable_baselines3
import torch
from gymnasium import spaces
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.torch_layers import BaseFeaturesExtractor
from stable_baselines3.common.vec_env import VecEnv

from aicon_baselines.agents.sb3.training_config import TrainingConfig


class ReadingsExtractor(BaseFeaturesExtractor):
    """All readings side by side; a bearing φ as (sin φ, cos φ), which does not jump at ±π.

    Args:
        observation_space: The readings, each (n,).
    """

    def __init__(self, observation_space: spaces.Dict) -> None:
        features_dim = 0
        for name, space in observation_space.spaces.items():
            size = int(np.prod(space.shape or ()))
            features_dim += 2 * size if is_bearing(name) else size

        super().__init__(observation_space, features_dim)
        self._names = list(observation_space.spaces)

    def forward(self, observations: dict[str, torch.Tensor]) -> torch.Tensor:
        """Return the features (B, n) of readings (B, n_i)."""
        features = []
        for name in self._names:
            reading = observations[name]
            features += [reading.sin(), reading.cos()] if is_bearing(name) else [reading]

        return torch.cat(features, dim=-1)


def is_bearing(name: str) -> bool:
    """Return whether a reading is an angle, which is not normalised; see `ReadingsExtractor`."""
    return name.endswith("bearing")


_NETWORK: dict[str, Any] = {
    "features_extractor_class": ReadingsExtractor,
    "net_arch": [256, 256],
    "activation_fn": torch.nn.ReLU,
}


def make_algorithm(config: TrainingConfig, envs: VecEnv) -> BaseAlgorithm:
    """Build what is trained, on the CPU; what is not named here is stable-baselines3's default."""
    common: dict[str, Any] = {"gamma": config.discount, "seed": config.seed, "device": "cpu"}
    if config.algorithm == "ppo":
        # σ = 0.6 of half the range of an action; the default, 1, would often be clipped.
        return stable_baselines3.PPO(
            "MultiInputPolicy",
            envs,
            n_steps=config.rollout,
            batch_size=min(256, config.rollout * config.envs),
            n_epochs=config.epochs,
            policy_kwargs=_NETWORK | {"log_std_init": -0.5},
            **common,
        )

    return stable_baselines3.SAC(
        "MultiInputPolicy",
        envs,
        buffer_size=min(300_000, config.steps),
        learning_starts=min(5000, config.steps // 4),
        # An update for every two steps; a step of the loop is one of each environment.
        gradient_steps=max(1, config.envs // 2),
        policy_kwargs=dict(_NETWORK),
        **common,
    )
