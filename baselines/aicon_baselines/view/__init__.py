"""A live view of an episode in the browser: the world, what the policy knows, what it decides."""

from aicon_baselines.view.episode import LiveEpisode
from aicon_baselines.view.live import LiveView
from aicon_baselines.view.opening import open_episode
from aicon_baselines.view.scenes import make_scene

__all__ = ["LiveEpisode", "LiveView", "make_scene", "open_episode"]
