"""Limits and contacts are what the physics say, and the servos are those of a robot."""

import numpy as np
import pytest

pytest.importorskip("mujoco")
pytest.importorskip("trimesh")

import mujoco

from aicon_envs.reach import ROBOTS, ReachEnv
from aicon_envs.reach.gaps import SIGHT
from aicon_envs.reach.robots import draw_postures
from aicon_envs.reach.scene import build_scene
from aicon_envs.reach.simulation import WINDUP, Simulation


def excluded(model: mujoco.MjModel) -> set[frozenset[str]]:
    pairs = set()
    for signature in model.exclude_signature.tolist():
        first, second = model.body(signature >> 16).name, model.body(signature & 0xFFFF).name
        pairs.add(frozenset((first, second)))
    return pairs


def test_gaps_are_the_distances_of_shapes_that_can_meet() -> None:
    """MuJoCo's distance of each pair, one after the other."""
    scene = build_scene(ROBOTS["ur5"])
    simulation = Simulation(scene)
    model, data = scene.model, simulation.data
    without = excluded(model)

    for posture in draw_postures(scene.low, scene.high, 30, np.random.default_rng(0)):
        simulation.start(posture, np.zeros((0, 3)))
        nearest = SIGHT
        for first in range(model.ngeom):
            for second in range(first):
                bodies = model.geom_bodyid[[first, second]]
                names = frozenset(model.body(body).name for body in bodies)
                if len(names) == 2 and names not in without:
                    distance = mujoco.mj_geomDistance(model, data, first, second, SIGHT, None)
                    nearest = min(nearest, distance)

        found = simulation.measure(posture, np.zeros((0, 3))).to_itself
        assert (found < 0.0) == (nearest < 0.0)
        if nearest > 0.0:
            assert found == pytest.approx(nearest, abs=1e-4)


def test_links_with_one_joint_between_them_and_those_of_the_srdf_may_touch() -> None:
    pairs = excluded(build_scene(ROBOTS["ur5"]).model)
    for may_touch in (
        {"base_link", "shoulder_link"},  # one joint
        {"forearm_link", "wrist_2_link"},  # the SRDF
        {"wrist_3_link", "ee_link"},  # fixed to each other
    ):
        assert frozenset(may_touch) in pairs
    for may_not in ({"base_link", "forearm_link"}, {"upper_arm_link", "wrist_2_link"}):
        assert frozenset(may_not) not in pairs


def test_a_robot_that_folds_touches_itself() -> None:
    env = ReachEnv("ur5", "position")
    env.reset(seed=0, options={"joints": np.array([0.0, -1.5, 2.2, -1.5, 0.0, 0.0])})
    touched = False
    for _ in range(100):
        *_, info = env.step(np.array([0.0, 0.0, 1.0, 0.0, 0.0, 0.0]))
        touched = touched or info["self_contact"]
        assert info["self_contact"] == info["collision"] == (info["self_gap"] < 0.0)
    assert touched and not info["ball_contact"]


def test_a_joint_that_is_driven_into_its_stop_is_seen_beyond_it() -> None:
    env = ReachEnv("ur5", "position")
    home = np.array([0.0, -1.571, 1.571, -1.571, -1.571, 3.0])
    env.reset(seed=0, options={"joints": home})
    seen = []
    for _ in range(30):
        *_, info = env.step(np.array([0.0, 0.0, 0.0, 0.0, 0.0, 1.5]))
        seen.append(info["limit_violation"])
        assert info["limit_violation"] == (info["limit_margin"] < 0.0)
    assert not seen[0] and seen[-1]


def test_a_ball_that_is_hit_is_reported() -> None:
    env = ReachEnv("ur5", "position", balls=1)
    env.reset(seed=0)
    simulation = env._simulation
    position, _ = simulation.tip
    simulation.step(np.zeros(6), position[None])
    assert simulation.gaps.to_balls < 0.0 <= simulation.gaps.to_itself


@pytest.mark.parametrize(
    "name", ["panda", "ur5", "xarm7", "z1", pytest.param("kinova", marks=pytest.mark.slow)]
)
def test_joints_follow_their_commands(name: str) -> None:
    env = ReachEnv(name, "position")
    before, _ = env.reset(seed=0)
    velocity = 0.2 * np.ones(env.action_space.shape)

    observation, *_ = [env.step(velocity) for _ in range(50)][-1]
    np.testing.assert_allclose(observation["q"] - before["q"], 0.2, atol=0.02)
    np.testing.assert_allclose(observation["dq"], velocity, atol=0.02)


def test_a_joint_that_was_blocked_turns_back_at_once() -> None:
    """The integral of its servo did not wind up."""
    env = ReachEnv("ur5", "position")
    home = np.array([0.0, -1.571, 1.571, -1.571, -1.571, 3.1])
    env.reset(seed=0, options={"joints": home})
    last = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 1.5])
    for _ in range(100):
        blocked, *_ = env.step(last)

    assert (np.abs(env._simulation.data.act - blocked["q"]) <= WINDUP + 1e-9).all()
    after, *_ = [env.step(-last) for _ in range(10)][-1]
    assert after["q"][-1] < blocked["q"][-1] - 0.1


def test_what_happens_between_two_observations_counts() -> None:
    env = ReachEnv("ur5", "position", balls=1)
    env.reset(seed=0)
    simulation = env._simulation
    position, _ = simulation.tip

    # The ball comes, and is gone before the step ends.
    simulation.data.mocap_pos[1] = position
    simulation.step(np.zeros(6), position[None] + [0.4, 0.0, 0.0])
    assert simulation.gaps.to_balls < 0.0
    assert simulation.measure(simulation.joints, simulation.data.mocap_pos[1:]).to_balls > 0.0
