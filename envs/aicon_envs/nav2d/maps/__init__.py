"""Random maps by class, each checked to have a way from start to target."""

from aicon_envs.nav2d.maps.generation import MAP_NAMES, check_map_name, make_map

__all__ = ["MAP_NAMES", "check_map_name", "make_map"]
