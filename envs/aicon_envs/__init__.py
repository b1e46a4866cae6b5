"""Gymnasium environments for gradient-based control; importing this package registers them.

Example:
    >>> import gymnasium as gym
    >>> import aicon_envs
    >>> env = gym.make("aicon/Nav2D-v0", map="u_trap")
"""

import aicon_envs.registration  # noqa: F401  # its import registers the environments
