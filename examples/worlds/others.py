"""What the worlds of others have in common: a package that may be missing, readings, a picture."""

from collections.abc import Mapping
from importlib import import_module
from typing import Any

import gymnasium
import numpy as np
from gymnasium.error import DependencyNotInstalled
from gymnasium.spaces import Box, Dict


def needed(module: str, package: str) -> Any:
    """A module of a package of others."""
    try:
        return import_module(module)
    except ModuleNotFoundError as error:
        raise DependencyNotInstalled(f"{error}: pip install {package}") from error


def readings(sizes: Mapping[str, int]) -> Dict:
    """What is read of a world, and how many numbers each is."""
    return Dict({name: Box(-np.inf, np.inf, (size,), np.float64) for name, size in sizes.items()})


class World(gymnasium.Env[Any, Any]):
    """A world of others, ``world``, that is shown and closed as it is."""

    world: Any

    def reset(self, *, seed: int | None = None, options: Any = None) -> Any:
        """Begin what is drawn; some worlds draw actions of their own, to come to rest."""
        if seed is not None:
            self.world.action_space.seed(seed)
        return super().reset(seed=seed)

    def render(self) -> Any:
        """A picture."""
        return self.world.render()

    def close(self) -> None:
        """Close the world."""
        self.world.close()
