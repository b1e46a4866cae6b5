"""The evaluation tasks, by name."""

from aicon_baselines.tasks.registry import load, names

__all__ = ["load", "names"]
