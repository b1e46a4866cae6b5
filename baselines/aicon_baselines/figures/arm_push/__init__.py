"""The film of an episode of the arm: its views, the strengths of its gradients and its errors."""

from aicon_baselines.figures.arm_push.figure import ArmFilm, draw_film, draw_still, make_figure
from aicon_baselines.figures.arm_push.recording import ArmRecording, record

__all__ = ["ArmFilm", "ArmRecording", "draw_film", "draw_still", "make_figure", "record"]
