"""What the worlds of others have in common: packages that may be missing, readings, a task."""

from collections.abc import Callable, Iterable, Mapping
from importlib import import_module
from typing import Any

import gymnasium
import numpy as np
from gymnasium.error import DependencyNotInstalled
from gymnasium.spaces import Box, Dict

from aicon_baselines.evaluation.task import Task
from aicon_baselines.tasks.side_by_side import side_by_side


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


def worlds_of(world: Callable[..., gymnasium.Env[Any, Any]]) -> Callable[..., Any]:
    """What makes the worlds of a batch, of what makes one for a condition and options."""

    def make_env(count: int, condition: str, horizon: int, **options: Any) -> Any:
        return side_by_side(lambda: world(condition, **options), count, horizon)

    return make_env


def world_task(
    module: str,
    world: Callable[..., gymnasium.Env[Any, Any]],
    conditions: Iterable[str],
    presets: Iterable[str],
    **others: Any,
) -> Task:
    """The task of a world.

    Args:
        module: Where its `Options` and `build` are; the task has its name.
        world: Makes one for a condition and options of its own.
        conditions: What there is to do.
        presets: Names of its policies.
        **others: Time step, horizon, and what else :class:`Task` takes.
    """
    usual = {"name": module, "chunk_size": 50, "maps": ("table",), "time_unit": "steps"}
    return Task(
        conditions=tuple(conditions),
        make_env=worlds_of(world),
        noiseless=tuple(conditions),
        model=module,
        presets=tuple(presets),
        **{**usual, **others},
    )
