"""The evaluation tasks, by name."""

from aicon_baselines.tasks.registry import load

__all__ = ["load"]
