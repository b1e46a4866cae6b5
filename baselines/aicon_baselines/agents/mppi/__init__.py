"""Model-predictive path integral control of pushT, by pytorch-mppi (extra [peers])."""

from aicon_baselines.agents.mppi.agent import Agent
from aicon_baselines.agents.mppi.options import PRESETS, Options
from aicon_baselines.agents.mppi.planner import Planner

__all__ = ["PRESETS", "Agent", "Options", "Planner"]
