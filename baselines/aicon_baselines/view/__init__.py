"""A live view of an episode in the browser: the world, what the policy knows, what it decides."""

from aicon_baselines.view.episode import LiveEpisode
from aicon_baselines.view.live import LiveView
from aicon_baselines.view.opening import make_scene, open_episode
from aicon_baselines.view.own import open_own, watch
from aicon_baselines.view.plane import PlaneScene
from aicon_baselines.view.recording import record_html
from aicon_baselines.view.scene import GradientArrow, Handle
from aicon_baselines.view.server import PageServer, serve

__all__ = [
    "GradientArrow",
    "Handle",
    "LiveEpisode",
    "LiveView",
    "PageServer",
    "PlaneScene",
    "make_scene",
    "open_episode",
    "open_own",
    "record_html",
    "serve",
    "watch",
]
