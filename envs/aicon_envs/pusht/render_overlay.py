"""What `render()` draws on top of the world."""

from collections.abc import Sequence
from dataclasses import dataclass

Color = tuple[int, int, int]
"""Red, green and blue, 0 to 255."""

Arrow = tuple[float, float, float, float, Color]
"""(x, y, dx, dy, color): from (x, y) to (x + dx, y + dy), px of the world."""

Mark = tuple[float, float, Color]
"""(x, y, color), px of the world."""


@dataclass(frozen=True)
class Overlay:
    """Arrows, points and a line of text, drawn by `render()` only and never in an observation.

    Attributes:
        arrows: Each (x, y, dx, dy, (r, g, b)): from (x, y) to (x + dx, y + dy), px of the world.
        points: Each (x, y, (r, g, b)), px of the world.
        text: A line at the top left.

    Example:
        >>> import gymnasium as gym
        >>> import aicon_envs
        >>> env = gym.make("aicon/PushT-v0", render_mode="rgb_array")
        >>> observation, info = env.reset(seed=0)
        >>> to_the_right = (100, 100, 40, 0, (200, 0, 0))
        >>> env.unwrapped.overlay = Overlay(arrows=[to_the_right], text="exploring")
        >>> env.render().shape
        (680, 680, 3)
    """

    arrows: Sequence[Arrow] = ()
    points: Sequence[Mark] = ()
    text: str = ""
