"""How readings enter the network."""

import numpy as np
import torch
from gymnasium import spaces
from stable_baselines3.common.torch_layers import BaseFeaturesExtractor


class Readings(BaseFeaturesExtractor):
    """All readings side by side; of a bearing φ its direction (sin φ, cos φ), which does not jump at ±π."""

    def __init__(self, observation_space: spaces.Dict) -> None:
        """Count the features of these observations."""
        sizes = {name: int(np.prod(box.shape or ())) for name, box in observation_space.spaces.items()}
        super().__init__(observation_space, sum((2 if is_bearing(name) else 1) * n for name, n in sizes.items()))
        self._names = list(sizes)

    def forward(self, observations: dict[str, torch.Tensor]) -> torch.Tensor:
        """Return the features (B, n)."""
        features = []
        for name in self._names:
            reading = observations[name]
            features += [reading.sin(), reading.cos()] if is_bearing(name) else [reading]
        return torch.cat(features, dim=-1)


def is_bearing(name: str) -> bool:
    """Return whether a reading is an angle, which is not normalised; see `Readings`."""
    return name.endswith("bearing")
