"""The paper's navigation figure, from a real rollout: how the potential changes as the agent moves.

The agent only ever computes one gradient, the one where it is. The figure asks what it would
compute elsewhere: at many positions the policy's own backward pass runs on the memory that the
agent had at that moment.
"""

from aicon_baselines.figures.nav2d.figure import NavigationRollout, make_figure
from aicon_baselines.figures.nav2d.recording import NavigationRecording, record

__all__ = ["NavigationRecording", "NavigationRollout", "make_figure", "record"]
