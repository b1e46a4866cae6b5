"""Classical navigation without a map, to compare AICON with: Bug 2 and a wall follower.

| file | content |
|---|---|
| `walls.py` | what they sense, and how they follow a wall |
| `bug2.py` | Bug 2 |
| `wall_follower.py` | a wall follower that counts its turns |
"""

from aicon_baselines.agents.nav2d.bug2 import Bug2
from aicon_baselines.agents.nav2d.wall_follower import WallFollower

__all__ = ["Bug2", "WallFollower"]
