"""The paper's navigation figure, from a real rollout: how the potential changes as the agent moves.

The agent only ever computes one gradient, the one where it is. The figure asks what it would
compute elsewhere: at many positions the policy's own backward pass runs on the memory that the
agent had at that moment.
"""

from aicon_baselines.figures.nav2d.field import Field, clearance, sample
from aicon_baselines.figures.nav2d.figure import make_figure
from aicon_baselines.figures.nav2d.film import draw_film, film_steps
from aicon_baselines.figures.nav2d.grid import Grid
from aicon_baselines.figures.nav2d.panels import choose_panels, summarize
from aicon_baselines.figures.nav2d.recording import NavigationRecording, record
from aicon_baselines.figures.nav2d.rollout_picture import draw_rollout

__all__ = [
    "Field",
    "Grid",
    "NavigationRecording",
    "choose_panels",
    "clearance",
    "draw_film",
    "draw_rollout",
    "film_steps",
    "make_figure",
    "record",
    "sample",
    "summarize",
]
