"""The evaluation tasks, by name."""

from importlib import import_module

from gymnasium.error import DependencyNotInstalled

from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.evaluation.task import Task
from aicon_baselines.extras import pip_command

_MODULES = {
    "nav2d": "aicon_baselines.tasks.nav2d",
    "pusht": "aicon_baselines.tasks.pusht",
    "arm_push": "aicon_baselines.tasks.arm_push",
    "reach": "aicon_baselines.tasks.reach",
}
_EXTRAS = {"pusht": "pusht", "arm_push": "panda", "reach": "reach"}


def names() -> tuple[str, ...]:
    """List the tasks, installed or not."""
    return tuple(_MODULES)


def load(name: str) -> Task:
    """Return the task of this name, importing its environment.

    An unknown name is an error that lists the names; where the environment is not installed, the
    error says what to install.
    """
    check_name(name)
    try:
        task: Task = import_module(_MODULES[name]).TASK
    except DependencyNotInstalled as error:
        raise ComparisonError(str(error)) from error  # the environment says how to get it
    except ModuleNotFoundError as error:
        needed = pip_command(_EXTRAS[name])
        raise ComparisonError(f"{error}; the task {name!r} needs: {needed}") from error
    return task


def check_name(name: str) -> None:
    """Refuse a name that is none of a task, with the list of those that are."""
    if name not in _MODULES:
        raise ComparisonError(f"unknown task {name!r}; valid tasks: {', '.join(_MODULES)}")
