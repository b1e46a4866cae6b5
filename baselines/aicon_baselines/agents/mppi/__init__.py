"""Model-predictive path integral control of pushT, by pytorch-mppi (extra [peers])."""

from aicon_baselines.agents.mppi.agent import Agent
from aicon_baselines.agents.mppi.options import PRESETS, Options

__all__ = ["PRESETS", "Agent", "Options"]
