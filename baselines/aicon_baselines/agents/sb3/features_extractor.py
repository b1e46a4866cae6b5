"""How readings enter the network."""

import numpy as np
import torch
from gymnasium import spaces
from stable_baselines3.common.torch_layers import BaseFeaturesExtractor


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
