"""The evaluation tasks: ours by name, other packages' by entry points, and yours as MODULE:TASK."""

from dataclasses import replace
from functools import cache
from importlib.metadata import entry_points

from gymnasium.error import DependencyNotInstalled

from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.evaluation.task import Lesson, Task
from aicon_baselines.extras import missing_extra
from aicon_baselines.named import find

_TASKS = {
    "nav2d": "aicon_baselines.tasks.nav2d:TASK",
    "pusht": "aicon_baselines.tasks.pusht:TASK",
    "arm_push": "aicon_baselines.tasks.arm_push:TASK",
    "reach": "aicon_baselines.tasks.reach:TASK",
}

_ALIASES = {"panda_push": "arm_push"}
"""Names that a task had before."""

_GROUP = "aicon.tasks"


def names() -> tuple[str, ...]:
    """List the tasks, installed or not: ours, then those of other packages."""
    return tuple(_sources())


def load(name: str) -> Task:
    """Return a task, importing its environment.

    Args:
        name: One of `names()`, a name that such a task had before, or "module:name" of a task of
            your own; the module may lie in this folder. The task goes by the name that loads it.

    Raises:
        ComparisonError: If there is no such task, with those that there are; if its environment is
            not installed, with what to install.
    """
    check_name(name)
    name = _ALIASES.get(name, name)
    source = _sources().get(name, name)

    try:
        task = find(source)
    except DependencyNotInstalled as error:
        raise ComparisonError(str(error)) from error  # the environment says how to get it
    except ModuleNotFoundError as error:
        raise ComparisonError(f"task {name!r}: {missing_extra(error)}") from error

    if not isinstance(task, Task):
        raise ComparisonError(f"{source!r} is a {type(task).__name__}; expected a Task")
    return task if task.name == name else replace(task, name=name)


def lesson_of(name: str) -> Lesson:
    """What a student of a task sees and does.

    Raises:
        ComparisonError: If there is no such task, or nothing to learn in it.
    """
    lesson = load(name).lesson
    if lesson is None:
        others = [task for task in names() if load(task).lesson is not None]
        raise ComparisonError(
            f"the task {name!r} has no lesson that says what a student learns; tasks that have "
            f"one: {', '.join(others)}, and your own with Task(lesson=...)"
        )
    return lesson


def check_name(name: str) -> None:
    """Refuse a name that cannot be one of a task, with the list of those that are."""
    if ":" not in name and name not in _sources() and name not in _ALIASES:
        raise ComparisonError(f"unknown task {name!r}; valid tasks: {choices()}")


def choices() -> str:
    """Say which tasks can be named."""
    return f"{', '.join(names())}, or MODULE:TASK of your own"


@cache
def _sources() -> dict[str, str]:
    """What each name stands for, as "module:name"."""
    others = {entry.name: entry.value for entry in entry_points(group=_GROUP)}
    return _TASKS | {name: source for name, source in others.items() if name not in _TASKS}
