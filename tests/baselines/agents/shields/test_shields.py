"""The worlds of the shield: what is felt is kept, and a region is entered where the physics say."""

import numpy as np
import pytest

from aicon_baselines.agents.shields import nav2d

pytest.importorskip("pymunk")


def test_a_wall_straight_ahead_is_not_touched_by_a_shielded_policy() -> None:
    from aicon_baselines.tasks import load
    from aicon_torch import Shield

    task = load("nav2d")
    episodes = [task.episode(1000)]
    env = task.make_env(1, "range", 300)
    touched = []
    for policy in (nav2d.Straight(), Shield(nav2d.Straight(), nav2d.model(), goes_around=False)):
        observation, info = env.reset(**task.reset_arguments(episodes))
        state = None
        for _ in range(120):
            action, state = policy.predict(observation, state, np.array([state is None]))
            observation, _, _, _, info = env.step(action)
        touched.append(bool(info["collision"][0]))
    assert touched == [True, False]


def test_the_clamp_stands_at_a_wall_and_the_wanderer_moves() -> None:
    seen = {"range": np.array([[0.1], [5.0]]), "bearing": np.zeros((2, 1))}
    action, _ = nav2d.clamped(nav2d.Straight()).predict(seen)
    np.testing.assert_allclose(action, [[0.0, 0.0], [0.5, 0.0]])
    assert nav2d.Wandering().predict(seen)[0].any()


def test_the_way_of_the_pusher_through_a_step_is_that_of_the_physics() -> None:
    from aicon_baselines.agents.shields import pusht
    from aicon_envs.pusht import PushTEnv

    env = pusht.Region(PushTEnv())
    observation, info = env.reset(seed=3)
    assert observation["region"].shape == (2,) and observation in env.observation_space
    for _ in range(20):
        place, velocity = info["pos_agent"], info["vel_agent"]
        target = observation["region"]
        observation, _, _, _, info = env.step(target.astype(np.float32))
        moved = pusht.SERVO.displacement_by_offset[-1] * (target - place)
        moved = moved + pusht.SERVO.displacement_by_velocity[-1] * velocity
        np.testing.assert_allclose(info["pos_agent"], place + moved, atol=1e-3)
    assert info["collision"]


@pytest.mark.slow
def test_a_ball_in_the_way_of_an_arm_is_touched_by_bare_joints_and_not_behind_a_shield() -> None:
    pytest.importorskip("mujoco")
    from aicon_baselines.agents.shields import arm
    from aicon_torch import Shield

    env, touched = arm.Posture(), []
    for policy in (arm.Straight(), Shield(arm.Straight(), arm.model())):
        observation, info = env.reset(seed=1000)
        assert observation in env.observation_space and not info["is_success"]
        state, contacts = None, 0
        for _ in range(150):
            seen = {key: value[None] for key, value in observation.items()}
            action, state = policy.predict(seen, state)
            observation, _, _, _, info = env.step(np.asarray(action)[0])
            contacts += int(info["collision"])
        touched.append(contacts > 0)
    assert touched == [True, False] and info["is_success"]
