"""The worlds of the shield: what is felt is kept, and a region is entered where the physics say."""

from typing import Any

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


def test_a_region_that_moves_goes_to_and_fro_and_never_over_the_goal() -> None:
    from aicon_baselines.ablations import PIXEL
    from aicon_baselines.agents.shields import pusht
    from aicon_envs.pusht import PushTEnv
    from aicon_torch.models.pusht.benchmark import GOAL_POSE

    env, goal = pusht.Region(PushTEnv(), is_moving=True), np.array(GOAL_POSE[:2]) / PIXEL
    for seed in range(3):
        observation, _ = env.reset(seed=seed)
        places = [observation["region"]]
        for _ in range(130):
            observation, _, _, _, _ = env.step(observation["agent_pos"].astype(np.float32))
            places.append(observation["region"])

        steps = np.linalg.norm(np.diff(places, axis=0), axis=-1)
        assert steps.max() <= 0.1 * pusht.SPEED + 1e-9
        assert np.linalg.norm(np.ptp(places, axis=0)) == pytest.approx(
            2 * pusht.AMPLITUDE, rel=0.01
        )
        assert np.linalg.norm(places - goal, axis=-1).min() > 70.0 + pusht.RADIUS


def test_a_pusher_that_is_sent_into_a_region_that_moves_stays_outside_behind_a_shield() -> None:
    from aicon_baselines.agents.shields import pusht
    from aicon_envs.pusht import PushTEnv
    from aicon_torch import Shield

    def into_it(observation: dict[str, Any]) -> Any:
        return observation["region"]

    env, entered = pusht.Region(PushTEnv(), is_moving=True), []
    shield = Shield(into_it, pusht.model(), nominal=pusht.mean_velocity)
    for guarded in (False, True):
        observation, _ = env.reset(seed=1)
        state, inside = None, False
        for _ in range(60):
            action = into_it(observation)
            if guarded:
                seen = {key: np.asarray(value)[None] for key, value in observation.items()}
                actions, state = shield.predict(seen, state)
                action = np.asarray(actions)[0]
            observation, _, _, _, info = env.step(action.astype(np.float32))
            inside |= info["collision"]
        entered.append(inside)
    assert entered == [True, False]


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


@pytest.mark.slow
def test_balls_that_move_are_seen_by_the_arm_and_its_shield() -> None:
    pytest.importorskip("mujoco")
    from aicon_baselines.agents.shields import arm

    env = arm.Posture(is_moving=True)
    observation, info = env.reset(seed=1000)
    first = [observation[f"ball_{number}"] for number in range(1, arm.MOVING + 1)]
    shield, state = arm.shielded(arm.Straight(), balls=arm.MOVING), None
    for _ in range(100):
        assert observation in env.observation_space
        seen = {key: value[None] for key, value in observation.items()}
        action, state = shield.predict(seen, state)
        observation, _, _, _, info = env.step(np.asarray(action)[0])
        assert not info["collision"]
    moved = [observation[f"ball_{number}"] for number in range(1, arm.MOVING + 1)]
    assert (np.linalg.norm(np.subtract(moved, first), axis=-1) > 0.05).all()
