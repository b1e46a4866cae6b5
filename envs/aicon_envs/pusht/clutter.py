"""Pictures that show less, or more, than the task: shapes that distract, and covers."""

import math
from typing import Literal, get_args

import gymnasium as gym
import numpy as np
from gymnasium.utils import RecordConstructorArgs
from numpy.typing import NDArray

from aicon_envs.arrays import BoolArray
from aicon_envs.checks import check_choice
from aicon_envs.pusht.spaces import PIXELS, Action, Observation
from aicon_envs.pusht.wrappers import ImperfectSensor

Picture = NDArray[np.uint8]
Mask = BoolArray

Kind = Literal["distractors", "covered", "hidden"]
"""Three shapes at fixed places; a third covered, elsewhere at each step; a third, always there."""

_LOOKALIKES = ((119, 136, 153), (144, 238, 144), (65, 105, 225))
"""Colours of the object, its goal and the pusher, of which a shape is one in three times."""

_SHAPES, _SHARE = 3, 1 / 3


class Clutter(ImperfectSensor, RecordConstructorArgs):
    """Draws into the pictures that the policy is given; the world stays as it is.

    Args:
        env: A pushT environment that observes pixels.
        kind: What is drawn.

    Raises:
        ValueError: If the environment observes no pixels, or there is no such kind.
    """

    def __init__(self, env: gym.Env[Observation, Action], kind: Kind) -> None:
        """Wrap an environment."""
        RecordConstructorArgs.__init__(self, kind=kind)
        super().__init__(env)
        check_choice("kind", kind, get_args(Kind))
        if PIXELS not in getattr(env.observation_space, "spaces", {}):
            raise ValueError("clutter is drawn into pictures: expected obs_type='pixels_agent_pos'")
        self._kind = kind

    def _sense_first(self, observation: Observation) -> Observation:
        """What is drawn is drawn anew in each episode."""
        self._layers = self._draw()
        return self._drawn_over(observation)

    def _sense(self, observation: Observation) -> Observation:
        """A cover is drawn anew at each step."""
        if self._kind == "covered":
            self._layers = self._draw()
        return self._drawn_over(observation)

    def _draw(self) -> list[tuple[Mask, Picture]]:
        """The shapes of an episode, or the cover of a step, each with its colour."""
        size, generator = self.observation_space[PIXELS].shape[:2], self._generator  # type: ignore[index]  # a Dict
        if self._kind == "distractors":
            masks = [random_polygon(size, generator) for _ in range(_SHAPES)]
        else:
            masks = [random_cover(size, generator, _SHARE)]
        return [(mask, random_colour(generator)) for mask in masks]

    def _drawn_over(self, observation: Observation) -> Observation:
        """The observation with what is drawn over it."""
        picture = np.array(observation[PIXELS])
        for mask, colour in self._layers:
            picture[mask] = colour
        return {**observation, PIXELS: picture}


def random_colour(generator: np.random.Generator) -> Picture:
    """A colour (3,), one in three times that of something in the world."""
    if generator.uniform() < 1 / 3:
        return np.array(_LOOKALIKES[generator.integers(len(_LOOKALIKES))], np.uint8)
    return generator.integers(0, 256, 3).astype(np.uint8)


def random_polygon(size: tuple[int, int], generator: np.random.Generator) -> Mask:
    """A triangle or a pentagon somewhere, 6 to 11 hundredths of the picture in radius."""
    corners = int(generator.choice([3, 5]))
    radius = generator.uniform(0.06, 0.11) * size[1]
    turn, center = generator.uniform(0, 2 * math.pi), generator.uniform(0.1, 0.9, 2) * size[1]

    # Within every side, whose distance from the middle is r cos(π/n).
    y, x = np.mgrid[: size[0], : size[1]] + 0.5
    inside = np.ones(size, np.bool_)
    for side in range(corners):
        angle = turn + 2 * math.pi * side / corners
        distance = math.cos(angle) * (x - center[0]) + math.sin(angle) * (y - center[1])
        inside &= distance < radius * math.cos(math.pi / corners)
    return inside


def random_cover(size: tuple[int, int], generator: np.random.Generator, share: float) -> Mask:
    """An upright rectangle somewhere with this share of the picture's area."""
    height, width = size
    aspect = math.exp(generator.uniform(-0.5, 0.5))
    tall, wide = math.sqrt(share * aspect), math.sqrt(share / aspect)
    top, left = generator.uniform(0, 1 - tall), generator.uniform(0, 1 - wide)
    covered = np.zeros(size, np.bool_)
    covered[round(top * height) : round((top + tall) * height)][
        :, round(left * width) : round((left + wide) * width)
    ] = True
    return covered
