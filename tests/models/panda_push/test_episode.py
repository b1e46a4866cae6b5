"""An episode of the arm, from its start to success."""

import pytest

pytest.importorskip("aicon_envs.panda_push")

from aicon_envs.panda_push import PandaPushEnv
from aicon_torch import make_policy


def test_it_pushes_the_object_to_its_target() -> None:
    """4 cm to the side; it needs about 3 s, and 10 s are enough."""
    env = PandaPushEnv(obs_type="pose")
    place = {"object_pose": (0.52, 0.0, 1.57), "target_pose": (0.52, 0.04, 1.57)}
    observation, info = env.reset(seed=1000, options=place)
    policy, memory = make_policy("panda_push", sensing="pose"), None

    for _ in range(1000):
        action, memory = policy.predict(observation, memory)
        observation, _, terminated, _, info = env.step(action)
        assert info["limit_margin"] > 0 and info["self_distance"] > 0
        if terminated:
            break

    assert info["is_success"] and not info["collision"]
