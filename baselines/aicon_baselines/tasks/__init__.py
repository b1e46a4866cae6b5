"""The evaluation tasks, by name."""

from aicon_baselines.tasks.check import check_task
from aicon_baselines.tasks.registry import check_name, choices, load, names
from aicon_baselines.tasks.side_by_side import side_by_side

__all__ = ["check_name", "check_task", "choices", "load", "names", "side_by_side"]
