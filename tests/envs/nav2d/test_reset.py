"""What the options of a reset ask for."""

import math
from typing import Any

import numpy as np
import pytest
from _nav2d_env import SQUARE, own_map

from aicon_envs.nav2d import Nav2DEnv


def test_map_seed_fixes_the_map_and_not_the_noise() -> None:
    env = Nav2DEnv(map="clutter")
    first, _ = env.reset(seed=0, options={"map_seed": 7})
    world = env.map

    second, _ = env.reset(seed=1, options={"map_seed": 7})
    assert env.map == world
    assert first["bearing"] != second["bearing"]


def test_reset_info_generates_the_map_again() -> None:
    env = Nav2DEnv(map="mixed")
    _, info = env.reset(seed=11)
    world = env.map

    env.reset(options={"map": info["map"], "map_seed": info["map_seed"]})
    assert env.map == world


# --- errors name the option

LINE = [(0, 0), (1, 1)]
FLAT = [(5, 5), (6, 6), (7, 7)]
CROSSED = [(5, 5), (6, 6), (6, 5), (5, 6)]
IN_SPACE = [(0, 0, 0), (1, 1, 1), (2, 0, 0)]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"mapp": "maze"}, ["mapp", "map_seed", "obstacles"]),
        ({"map": "u_trapp"}, ["map", "u_trap_05", "maze", "mixed"]),
        ({"map_seed": -1}, ["map_seed"]),
        ({"map_seed": 0.5}, ["map_seed"]),
        ({"obstacles": [SQUARE]}, ["start", "target"]),
        ({"start": (0, 0), "target": (1, 1)}, ["obstacles"]),
        (own_map() | {"map": "maze"}, ["map"]),
        (own_map(start=(1, 2, 3)), ["start", "metres"]),
        (own_map(target=(1.0, math.nan)), ["target"]),
        (own_map(target="somewhere"), ["target"]),
        (own_map([LINE]), ["obstacles[0]"]),
        (own_map([SQUARE, IN_SPACE]), ["obstacles[1]"]),
        (own_map([CROSSED]), ["obstacles[0]", "Self-intersection"]),
        (own_map([FLAT]), ["obstacles[0]"]),
        ({"obstacles": 3, "start": (0, 0), "target": (1, 0)}, ["obstacles"]),
        (own_map(start=(1.5, 0.0)), ["start", "radius"]),
        (own_map(start=(0.95, 0.0)), ["start", "radius"]),
    ],
)
def test_bad_options(options: dict[str, Any], words: list[str]) -> None:
    with pytest.raises(ValueError) as error:
        Nav2DEnv().reset(seed=0, options=options)
    assert all(word in str(error.value) for word in words), str(error.value)


def test_constants_are_plain_numbers() -> None:
    physics: Any = {"max_speed": "0.4", "dt": np.float32(0.05)}
    constants = Nav2DEnv(**physics).physics
    assert constants.max_speed == 0.4
    assert type(constants.dt) is float
