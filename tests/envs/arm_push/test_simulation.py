"""The arm's servos and sensors."""

from itertools import combinations

import numpy as np
import pytest

pytest.importorskip("aicon_envs.arm_push")

from aicon_envs.arm_push import ArmPushEnv


@pytest.fixture(scope="module")
def env() -> ArmPushEnv:
    return ArmPushEnv(obs_type="pose")


def test_joint_velocities_are_those_commanded(env: ArmPushEnv) -> None:
    env.reset(seed=2)
    velocity = np.array([0.1, -0.1, 0.05, 0.1, -0.05, 0.1, 0.2])

    before, *_ = [env.step(velocity) for _ in range(50)][-1]  # the servos lag behind by 0.1 s
    observation, *_ = [env.step(velocity) for _ in range(50)][-1]
    np.testing.assert_allclose(observation["q"] - before["q"], 0.5 * velocity, atol=0.002)
    np.testing.assert_allclose(observation["dq"], velocity, atol=0.01)


def test_the_wrist_feels_the_weight_of_the_tool(env: ArmPushEnv) -> None:
    readings = [env.reset(seed=3)[0]["ft"]]
    readings += [env.step(np.zeros(7))[0]["ft"] for _ in range(50)]
    assert np.mean(readings, axis=0)[2] == pytest.approx(-0.25 * 9.81, abs=0.1)


def test_the_self_distance_is_that_of_points_on_the_capsules(env: ArmPushEnv) -> None:
    """By brute force over points on the axes of all capsules that can meet."""
    env.reset(seed=1)
    data = env._simulation.data
    shares = np.linspace(0.0, 1.0, 201)[:, None]

    axes = []
    for link, start, end, radius in env.description()["capsules"]:
        body = data.body(f"panda_link{link}" if link < 8 else "tool")
        points = (1.0 - shares) * np.array(start) + shares * np.array(end)
        axes.append((link, body.xpos + points @ body.xmat.reshape(3, 3).T, radius))

    gaps = []
    for (link, points, radius), (other_link, other_points, other_radius) in combinations(axes, 2):
        if abs(link - other_link) > 2:
            distances = np.linalg.norm(points[:, None] - other_points, axis=-1)
            gaps.append(distances.min() - radius - other_radius)

    assert env._simulation.self_distance == pytest.approx(min(gaps), abs=1e-4)


def test_what_was_touched_within_a_step_is_told_although_it_has_let_go(env: ArmPushEnv) -> None:
    env.reset(seed=7)
    velocity = 0.4 * np.random.default_rng(7).uniform(env.action_space.low, env.action_space.high)

    told, still_touching = [], []
    for _ in range(60):
        *_, info = env.step(velocity)
        told.append(info["collision"])
        still_touching.append(env._simulation._is_touching())
    assert not told[0] and sum(told) > sum(still_touching)
    assert all(told[step] for step in np.flatnonzero(still_touching))


def test_a_joint_that_was_blocked_turns_back_at_once(env: ArmPushEnv) -> None:
    """The integral of its servo did not wind up while the stick was pressed on the table."""
    env.reset(seed=2)
    down = np.array([0.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0])
    for _ in range(200):
        blocked, *_ = env.step(down)
    simulation = env._simulation
    torques = 4500.0 * (simulation.data.act[:4] - simulation.joints[:4])
    assert (np.abs(torques) <= 87.0 + 450.0 * np.abs(simulation.speeds[:4]) + 1e-6).all()

    after, *_ = [env.step(-down) for _ in range(30)][-1]
    assert after["q"][1] < blocked["q"][1] - 0.05


@pytest.mark.parametrize("friction", [0.175, 0.525])
def test_the_friction_at_the_stick_is_its_own_whatever_the_objects(friction: float) -> None:
    env = ArmPushEnv(obs_type="pose", friction=friction)
    env.reset(seed=0)
    simulation = env._simulation
    assert frictions_at(env, "table") == {friction}

    x, y, _ = simulation.data.site("tip").xpos
    simulation.place((x, y, 0.0))  # into the stick
    assert frictions_at(env, "stick") == {0.2}


def frictions_at(env: ArmPushEnv, geom: str) -> set[float]:
    """Coefficients of sliding friction where a shape touches others."""
    simulation = env._simulation
    shape = simulation.model.geom(geom).id
    return {float(c.friction[0]) for c in simulation.data.contact if shape in c.geom}
