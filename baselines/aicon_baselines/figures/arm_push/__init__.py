"""The figure of an episode of the arm: its views, the strengths of its gradients and its errors."""

from aicon_baselines.figures.arm_push.figure import ArmRollout, make_figure
from aicon_baselines.figures.arm_push.recording import ArmRecording, record

__all__ = ["ArmRecording", "ArmRollout", "make_figure", "record"]
