"""Pictures for people."""

import numpy as np
from _environments import assert_same
from _pusht_env import APART

from aicon_envs.pusht import OBJECTS, PushTEnv


def test_the_target_is_in_renderings_only() -> None:
    env = PushTEnv(
        obs_type="pixels",
        render_mode="rgb_array",
        visualization_width=200,
        visualization_height=100,
    )
    pixels, _ = env.reset(seed=0)
    plain = env.render()
    assert plain is not None and plain.shape == (100, 200, 3) and plain.dtype == np.uint8

    env.step(np.array([200.0, 300.0], np.float32))
    drawn = env.render()
    assert drawn is not None
    assert (drawn == (255, 0, 0)).all(axis=-1).any()
    assert not (plain == (255, 0, 0)).all(axis=-1).any()

    assert_same(env.reset(seed=0)[0], pixels)


def test_pictures_show_other_objects() -> None:
    pictures = []
    for name in OBJECTS:
        env = PushTEnv(object=name, render_mode="rgb_array")
        env.reset(options={"reset_to_state": APART})
        pictures.append(np.asarray(env.render()).tobytes())

    assert len(set(pictures)) == len(OBJECTS)
