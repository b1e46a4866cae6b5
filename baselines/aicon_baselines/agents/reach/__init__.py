"""Inverse kinematics, to compare AICON with: damped least squares, mink, pink and placo.

| file | content |
|---|---|
| `kinematics.py` | the robot as they know it, and how far it is from its target |
| `inverse_kinematics.py` | what all have in common |
| `damped_least_squares.py` | the damped pseudo-inverse of the Jacobian |
| `mink.py`, `pink.py`, `placo.py` | a quadratic program in each step, by the library of this name |
| `pinocchio_files.py` | the robot as pink and placo read it |
| `random_places.py` | where they go when they are held up, if they may |
"""

from aicon_baselines.agents.reach.damped_least_squares import DampedLeastSquares
from aicon_baselines.agents.reach.mink import Mink
from aicon_baselines.agents.reach.pink import Pink
from aicon_baselines.agents.reach.placo import Placo

__all__ = ["DampedLeastSquares", "Mink", "Pink", "Placo"]
