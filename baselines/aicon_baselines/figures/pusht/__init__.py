"""The paper's pushing figure, from a real episode: the gradients at the pusher, and what it does.

Everything drawn is what happened or what the policy knew: contacts, likelihoods, gradients and the
commanded motion are read off the trace of each step.
"""

from aicon_baselines.figures.pusht.figure import PushRollout, make_figure
from aicon_baselines.figures.pusht.recording import PushRecording, record

__all__ = ["PushRecording", "PushRollout", "make_figure", "record"]
