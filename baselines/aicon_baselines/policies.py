"""The policies that can be compared, by task and name."""

from collections.abc import Callable
from functools import partial

from aicon_baselines.errors import ComparisonError
from aicon_baselines.protocol import Predictor

Factory = Callable[[str | None], Predictor]
"""Builds a policy for a condition of its task; None stands for the usual one."""

_TASKS = ("nav2d",)


def _preset(task: str, preset: str, condition: str | None) -> Predictor:
    # Imported on demand: comparing a policy needs the dependencies of that policy only.
    from aicon_torch import make_policy

    return make_policy(task, preset=preset, **({} if condition is None else {"sensing": condition}))


def names(task: str) -> tuple[str, ...]:
    """List the policies of a task, the presets of its model; an unknown task is an error that lists the tasks."""
    from aicon_torch import presets

    if task not in _TASKS:
        raise ComparisonError(f"unknown task {task!r}; valid tasks: {', '.join(_TASKS)}")
    return presets(task)


def factory(task: str, name: str) -> Factory:
    """Return what builds a policy, without building it; an unknown name is an error that lists the names."""
    if name not in names(task):
        raise ComparisonError(f"unknown policy {name!r} for task {task!r}; valid policies: {', '.join(names(task))}")
    return partial(_preset, task, name)


def make(task: str, name: str, condition: str | None = None) -> Predictor:
    """Build a policy, for example `make("nav2d", "aicon")`.

    Args:
        task: Name of the task; an unknown one is an error that lists the tasks.
        name: Name of the policy; an unknown one is an error that lists the policies of the task.
        condition: The task's condition that the policy is for; by default the usual one.
    """
    return factory(task, name)(condition)
