"""The evaluation task "arm_push"."""

from aicon_baselines.tasks.panda_push import ARM_PUSH as TASK

__all__ = ["TASK"]
