"""Pictures for people, with an overlay."""

import numpy as np
from _environments import assert_same
from _pusht_env import APART

from aicon_envs.pusht import OBJECTS, Overlay, PushTEnv


def test_overlay_and_target_are_in_renderings_only() -> None:
    env = PushTEnv(
        obs_type="pixels",
        render_mode="rgb_array",
        visualization_width=200,
        visualization_height=100,
    )
    pixels, _ = env.reset(seed=0)
    plain = env.render()
    assert plain is not None and plain.shape == (100, 200, 3) and plain.dtype == np.uint8

    env.overlay = Overlay(
        arrows=[(100, 100, 50, 20, (1, 2, 3))], points=[(400, 400, (4, 5, 6))], text="exploring"
    )
    drawn = env.render()
    assert drawn is not None
    for color in ((1, 2, 3), (4, 5, 6)):
        assert (drawn == color).all(axis=-1).any()
        assert not (plain == color).all(axis=-1).any()

    assert_same(env.reset(seed=0)[0], pixels)


def test_pictures_show_other_objects() -> None:
    pictures = []
    for name in OBJECTS:
        env = PushTEnv(object=name, render_mode="rgb_array")
        env.reset(options={"reset_to_state": APART})
        pictures.append(np.asarray(env.render()).tobytes())

    assert len(set(pictures)) == len(OBJECTS)
