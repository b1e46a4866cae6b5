"""The evaluation tasks, by name."""

from importlib import import_module

from gymnasium.error import DependencyNotInstalled

from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.evaluation.task import Task

_MODULES = {
    "nav2d": "aicon_baselines.tasks.nav2d",
    "pusht": "aicon_baselines.tasks.pusht",
    "panda_push": "aicon_baselines.tasks.panda_push",
}


def load(name: str) -> Task:
    """Return the task of this name, importing its environment; an unknown name is an error that lists the names."""
    if name not in _MODULES:
        raise ComparisonError(f"unknown task {name!r}; valid tasks: {', '.join(_MODULES)}")
    try:
        task: Task = import_module(_MODULES[name]).TASK
    except (ModuleNotFoundError, DependencyNotInstalled) as error:
        extra = name.partition("_")[0]
        raise ComparisonError(f"{error}; the task {name!r} needs: pip install 'aicon-torch[{extra}]'") from error
    return task
