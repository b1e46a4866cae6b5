"""The policies that can be compared, by task and name."""

from collections.abc import Callable
from functools import partial

from aicon_baselines.errors import ComparisonError
from aicon_baselines.protocol import Predictor

Factory = Callable[[str | None], Predictor]
"""Builds a policy for a condition of its task; None stands for the usual one."""

_NAV2D_PRESETS = (
    "aicon",
    "paper_literal",
    "steepest",
    "potential_field",
    "no_progress_exit",
    "no_level_hold",
    "no_obstacle_nullspace",
    "no_projection",
    "no_exploration",
    "no_softmax",
    "no_hysteresis",
)


def _nav2d(preset: str, condition: str | None) -> Predictor:
    # Imported on demand: comparing a policy needs the dependencies of that policy only.
    from aicon_torch import make_policy

    return make_policy("nav2d", preset=preset, sensing=condition or "range")


_POLICIES: dict[str, dict[str, Factory]] = {"nav2d": {preset: partial(_nav2d, preset) for preset in _NAV2D_PRESETS}}


def names(task: str) -> tuple[str, ...]:
    """List the policies of a task; an unknown task is an error that lists the tasks."""
    if task not in _POLICIES:
        raise ComparisonError(f"unknown task {task!r}; valid tasks: {', '.join(_POLICIES)}")
    return tuple(_POLICIES[task])


def factory(task: str, name: str) -> Factory:
    """Return what builds a policy, without building it; an unknown name is an error that lists the names."""
    if name not in names(task):
        raise ComparisonError(f"unknown policy {name!r} for task {task!r}; valid policies: {', '.join(names(task))}")
    return _POLICIES[task][name]


def make(task: str, name: str, condition: str | None = None) -> Predictor:
    """Build a policy, for example `make("nav2d", "aicon")`.

    Args:
        task: Name of the task; an unknown one is an error that lists the tasks.
        name: Name of the policy; an unknown one is an error that lists the policies of the task.
        condition: The task's condition that the policy is for; by default the usual one.
    """
    return factory(task, name)(condition)
