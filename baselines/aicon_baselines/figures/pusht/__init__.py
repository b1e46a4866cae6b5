"""The paper's pushing figure, from a real episode: the gradients at the pusher, and what it does.

Everything drawn is what happened or what the policy knew: contacts, likelihoods, gradients and the
commanded motion are read off the trace of each step.
"""

from aicon_baselines.figures.pusht.figure import make_figure
from aicon_baselines.figures.pusht.film import draw_film
from aicon_baselines.figures.pusht.panels import at_corners, choose_panels, phase, summarize
from aicon_baselines.figures.pusht.recording import PushRecording, record
from aicon_baselines.figures.pusht.rollout_picture import draw_rollout

__all__ = [
    "PushRecording",
    "at_corners",
    "choose_panels",
    "draw_film",
    "draw_rollout",
    "make_figure",
    "phase",
    "record",
    "summarize",
]
