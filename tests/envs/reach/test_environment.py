"""The arm that reaches, as an environment."""

import math
from typing import Any

import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

pytest.importorskip("mujoco")
pytest.importorskip("trimesh")

from aicon_envs.reach import ROBOTS, ReachEnv, Robot
from aicon_envs.reach.balls import draw_path
from aicon_envs.to_and_fro import SAMPLES

TARGETS = ("position", "axis", "pose")
SLOW_TO_LOAD = ("kinova", "so101")


def drive(env: ReachEnv, joints: np.ndarray, steps: int = 400) -> dict[str, Any]:
    """Move straight to values of the joints, until success."""
    info: dict[str, Any] = {}
    for _ in range(steps):
        q = env._simulation.joints
        _, _, terminated, _, info = env.step(np.clip(5.0 * (joints - q), -1.5, 1.5))
        if terminated:
            break
    return info


@pytest.mark.filterwarnings("ignore:.*we recommend using a symmetric and normalized space")
@pytest.mark.parametrize("target", TARGETS)
def test_gymnasium_finds_nothing_wrong(target: Any) -> None:
    check_env(ReachEnv("ur5", target, balls=2, ball_speed=0.2), skip_render_check=True)


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[pytest.mark.slow] * (name in SLOW_TO_LOAD)) for name in ROBOTS],
)
def test_every_robot_holds_its_home_free_of_contact(name: str) -> None:
    env = ReachEnv(name, "position")
    observation, _ = env.reset(seed=0)
    home = observation["q"]

    for _ in range(20):
        observation, *_, info = env.step(np.zeros(env.action_space.shape))
        assert not info["collision"] and not info["limit_violation"]
    np.testing.assert_allclose(observation["q"], home, atol=1e-3)


@pytest.mark.parametrize("target", TARGETS)
def test_the_target_is_reached_at_the_joints_that_it_was_made_of(target: Any) -> None:
    env = ReachEnv("ur5", target, start="random")
    for seed in range(10):
        env.reset(seed=seed)
        assert env._episode is not None
        joints = env._episode.target_joints
        _, info = env.reset(seed=seed, options={"joints": joints, "target_joints": joints})
        assert info["distance"] < 1e-9 and info["angle"] < 1e-6 and info["is_success"]
        assert not info["collision"] and info["limit_margin"] > 0.049


def test_an_episode_ends_where_the_tip_arrives() -> None:
    env = ReachEnv("ur5", "pose")
    env.reset(seed=0)
    near = np.array([0.3, -1.3, 1.4, -1.4, -1.3, 0.4])
    env.reset(seed=0, options={"target_joints": near})
    assert drive(env, near)["is_success"]


def test_what_counts_is_what_was_asked_for() -> None:
    turned = np.array([0.0, -1.571, 1.571, -1.571, -1.571, 1.0])  # the last joint turns about z
    angles = {}
    for target in TARGETS:
        env = ReachEnv("ur5", target)
        _, info = env.reset(seed=0, options={"target_joints": turned})
        angles[target] = info["angle"]
        assert info["distance"] < 1e-9
    assert angles == pytest.approx({"position": 0.0, "axis": 0.0, "pose": 1.0}, abs=1e-6)


def test_an_episode_is_that_of_its_seed() -> None:
    env = ReachEnv("panda", "pose", "random", balls=1, ball_speed=0.2)
    first, other, again = (env.reset(seed=seed)[0] for seed in (3, 4, 3))
    for name in first:
        np.testing.assert_array_equal(first[name], again[name])
        assert not np.array_equal(first[name], other[name]) or name == "dq"


def test_options_change_nothing_but_what_they_name() -> None:
    env = ReachEnv("ur5", "pose")
    drawn, _ = env.reset(seed=3)
    other, _ = env.reset(seed=3, options={"joints": drawn["q"] + 0.1})
    np.testing.assert_array_equal(drawn["target_position"], other["target_position"])


def test_a_quaternion_says_the_rotation_of_the_target() -> None:
    env = ReachEnv("ur5", "pose")
    observation, _ = env.reset(seed=0)
    w, x, y, z = observation["target_orientation"]
    axis = [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)]
    np.testing.assert_allclose(env._target[1][:, 2], axis, atol=1e-12)


def test_a_ball_goes_to_and_fro_at_its_speed() -> None:
    path = draw_path(np.zeros(3), np.ones(3), 0.2, np.random.default_rng(0))
    times = np.arange(0.0, 2 * math.pi / path.frequency, 1e-3)
    places = np.array([path.at(time) for time in times])
    speeds = np.linalg.norm(np.diff(places, axis=0), axis=1) / 1e-3
    assert speeds.max() == pytest.approx(0.2, rel=1e-3)

    ends = path.everywhere()
    assert len(ends) == SAMPLES
    assert np.linalg.norm(places - path.middle, axis=1).max() == pytest.approx(0.3, rel=1e-4)
    assert np.linalg.norm(ends[0] - ends[-1]) == pytest.approx(0.6)


def test_a_ball_leaves_the_target_free_at_all_times() -> None:
    env = ReachEnv("xarm7", "pose", balls=1, ball_speed=0.2)
    for seed in range(5):
        env.reset(seed=seed)
        assert env._episode is not None
        (path,) = env._episode.balls
        for place in path.everywhere():
            gaps = env._simulation.measure(env._episode.target_joints, place[None])
            assert gaps.to_balls >= 0.05


def test_a_robot_may_be_any_urdf() -> None:
    panda = ROBOTS["panda"]
    env = ReachEnv(Robot(panda.urdf, "panda_link4"), "position")
    assert env.action_space.shape == (4,)
    assert env.description()["tip"] == "panda_link4"


def test_a_home_may_be_a_list_or_an_array() -> None:
    ur5 = ROBOTS["ur5"]
    for kind in (list, np.array):
        home: Any = kind(ur5.home)
        assert Robot(ur5.urdf, ur5.tip, ur5.srdf, home) == ur5
        gains: Any = kind([[1.0, 2.0]] * 6)
        assert Robot(ur5.urdf, ur5.tip, gains=gains).gains == ((1.0, 2.0),) * 6
    with pytest.raises(ValueError, match="home must be 6 finite numbers"):
        ReachEnv(Robot(ur5.urdf, ur5.tip, home="up"))  # type: ignore[arg-type]  # wrong on purpose


@pytest.mark.parametrize("number", [0, -1, 3, 1.5, "first"])
def test_a_ball_that_is_not_there_cannot_be_moved(number: Any) -> None:
    env = ReachEnv("ur5", balls=2)
    env.reset(seed=0)
    with pytest.raises(ValueError, match="number must be"):
        env.move_ball(number, (0.0, 0.0, 2.0))


def test_speeds_are_those_of_the_description_if_they_are_less() -> None:
    env = ReachEnv("panda", speed=2.5)
    speeds = [2.175] * 4 + [2.5] * 3
    np.testing.assert_allclose(env.description()["speed"], speeds)
    np.testing.assert_allclose(env.action_space.high, speeds)
    tiago = ReachEnv("tiago", speed=1.5).description()["speed"]
    assert tiago[0] == pytest.approx(0.07)  # m/s of the torso


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"robot": "r2d2"}, "robot must be a Robot or one of panda, ur5"),
        ({"robot": Robot("panda_description/urdf/panda.urdf", "nose")}, "tip must be a link of"),
        ({"robot": Robot("panda_description/urdf/panda.urdf", "panda_link0")}, "must be moved by"),
        ({"target": "heading"}, "target must be one of position, axis, pose"),
        ({"start": "away"}, "start must be one of home, random"),
        ({"speed": 0.0}, "speed must be"),
        ({"balls": -1}, "balls must be"),
        ({"angle_tolerance": 0.0}, "angle_tolerance must be"),
    ],
)
def test_arguments_are_named(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        ReachEnv(**arguments)


def test_a_file_that_is_not_there_is_named() -> None:
    with pytest.raises(FileNotFoundError, match="nowhere.urdf is no file"):
        ReachEnv(Robot("nowhere.urdf", "tip"))


def test_joints_of_the_options_are_within_the_limits() -> None:
    env = ReachEnv("ur5")
    for wrong in ([0.0] * 5, [4.0] * 6, "home"):
        with pytest.raises(ValueError, match="joints must be 6 finite numbers within the limits"):
            env.reset(options={"joints": wrong})
