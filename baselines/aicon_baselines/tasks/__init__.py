"""The evaluation tasks, by name."""

from aicon_baselines.tasks.registry import check_name, load, names

__all__ = ["check_name", "load", "names"]
