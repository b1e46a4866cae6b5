"""The policies that can be compared, by task and name."""

from collections.abc import Callable
from functools import partial
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.evaluation.protocol import Predictor
from aicon_baselines.tasks import load

Factory = Callable[[str], Predictor]
"""Builds a policy for a condition of its task."""


def _preset(task: str, preset: str, options: dict[str, Any], condition: str) -> Predictor:
    # Imported on demand: comparing a policy needs the dependencies of that policy only.
    from aicon_torch import make_policy

    return make_policy(task, preset=preset, **load(task).policy_options(condition) | options)


def names(task: str) -> tuple[str, ...]:
    """List the policies of a task, the presets of its model; an unknown task is an error that lists the tasks."""
    from aicon_torch import presets

    return presets(load(task).name)


def factory(task: str, name: str, **options: Any) -> Factory:
    """Return what builds a policy, without building it.

    Args:
        task: Name of the task; an unknown one is an error that lists the tasks.
        name: Name of the policy; an unknown one is an error that lists the policies of the task.
        **options: Options of the policy, which override those of its name and of the condition.
    """
    if name not in names(task):
        raise ComparisonError(f"unknown policy {name!r} for task {task!r}; valid policies: {', '.join(names(task))}")
    return partial(_preset, task, name, options)


def compiled(build: Factory) -> Factory:
    """Return what builds the same policy of the library with its step compiled."""
    return partial(_compiled, build)


def _compiled(build: Any, condition: str) -> Predictor:
    policy: Predictor = build(condition).compile()
    return policy


def make(task: str, name: str, condition: str | None = None) -> Predictor:
    """Build a policy, for example `make("nav2d", "aicon")`.

    Args:
        task: Name of the task; an unknown one is an error that lists the tasks.
        name: Name of the policy; an unknown one is an error that lists the policies of the task.
        condition: The task's condition that the policy is for; by default the usual one.
    """
    return factory(task, name)(condition or load(task).conditions[0])


def saved_agent(task: str, folder: Path, sampled: bool = False) -> tuple[str, Factory]:
    """Return the name that a saved agent of stable-baselines3 gets in the rows, and what builds it.

    It is loaded once here, so that what does not fit is an error before anything runs.

    Args:
        task: Name of the task.
        folder: Folder of the agent.
        sampled: Whether it draws its actions, as in training, instead of taking the most likely ones.
    """
    folder = folder.resolve()
    return import_sb3().Agent(folder, task, sampled).name, partial(_saved_agent, task, folder, sampled)


def import_sb3() -> ModuleType:
    """Import `aicon_baselines.agents.sb3`; without stable-baselines3 an error says how to install it."""
    try:
        return import_module("aicon_baselines.agents.sb3")
    except ModuleNotFoundError as error:
        raise ComparisonError(f"{error}; agents of stable-baselines3 need: pip install 'aicon-torch[sb3]'") from error


def _saved_agent(task: str, folder: Path, sampled: bool, condition: str) -> Predictor:
    agent: Predictor = import_sb3().Agent(folder, task, sampled)
    return agent


def diffusion_policy(
    task: str, source: str, sampler: str | None = None, inference_steps: int | None = None
) -> tuple[str, Factory]:
    """Return the name that a saved diffusion policy gets in the rows, and what builds it.

    It is loaded once here, so that what does not fit is an error before anything runs.

    Args:
        task: Name of the task, "pusht".
        source: Folder of the policy, or the name of a repository of the Hugging Face hub.
        sampler: "DDPM" or "DDIM"; by default the policy's.
        inference_steps: Number of denoising steps; by default the policy's.
    """
    if task != "pusht":
        raise ComparisonError(f"diffusion policies push: compare them with --task pusht, not {task}")
    from aicon_baselines.agents.diffusion.hub import locate

    folder = locate(source)
    name = _diffusion_policy(folder, sampler, inference_steps, "").name
    return name, partial(_diffusion_policy, folder, sampler, inference_steps)


def _diffusion_policy(folder: Path, sampler: str | None, inference_steps: int | None, condition: str) -> Any:
    from aicon_baselines.agents.diffusion.agent import Agent

    return Agent(folder, sampler, inference_steps)
