"""Two-dimensional navigation with a disc agent that senses one bearing and one clearance."""

from aicon_envs.nav2d.environment import Nav2DEnv
from aicon_envs.nav2d.maps import MAP_NAMES, make_map
from aicon_envs.nav2d.physics import Physics
from aicon_envs.nav2d.rendering import Scene
from aicon_envs.nav2d.shortest_path import shortest_path_length
from aicon_envs.nav2d.vector import Nav2DVectorEnv
from aicon_envs.nav2d.world import NavigationMap

__all__ = [
    "MAP_NAMES",
    "Nav2DEnv",
    "Nav2DVectorEnv",
    "NavigationMap",
    "Physics",
    "Scene",
    "make_map",
    "shortest_path_length",
]
