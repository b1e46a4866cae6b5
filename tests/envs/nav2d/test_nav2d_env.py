"""Properties of the navigation environment, alone and as a batch."""

import math
import warnings
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
import shapely
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from shapely.geometry import Polygon

import aicon_envs  # noqa: F401  (registers the environments)
from aicon_envs.nav2d import MAP_NAMES, Nav2DEnv, Nav2DVectorEnv, make_map

ID = "aicon/Nav2D-v0"
SQUARE = [(1.0, -1.0), (2.0, -1.0), (2.0, 1.0), (1.0, 1.0)]
SENSING = ("range", "range_bearing")
QUIET: Any = {"bearing_noise": 0.0, "range_noise": 0.0, "actuation_noise": 0.0}


def own_map(obstacles: Any = (SQUARE,), start: Any = (0.0, 0.0), target: Any = (4.0, 0.0)) -> dict[str, Any]:
    return {"obstacles": list(obstacles), "start": start, "target": target}


def random_actions(steps: int, *shape: int, seed: int = 0) -> NDArray[np.float32]:
    return np.random.default_rng(seed).uniform(-1.0, 1.0, size=(steps, *shape, 2)).astype(np.float32)


def velocity(x: float, y: float) -> NDArray[np.float32]:
    return np.array([x, y], dtype=np.float32)


def rollout(env: Nav2DEnv, actions: NDArray[np.float32], **reset: Any) -> NDArray[np.float64]:
    """Return every number that the environment gave, in order."""
    observation, info = env.reset(**reset)
    record = [*observation.values(), info["position"]]
    for action in actions:
        observation, reward, terminated, truncated, info = env.step(action)
        record += [*observation.values(), info["position"], info["clearance"], reward, terminated, truncated]
    return np.concatenate([np.ravel(value).astype(np.float64) for value in record])


def assert_same(first: Any, second: Any) -> None:
    """Observations, infos and other results are equal, number for number."""
    if isinstance(first, dict):
        assert first.keys() == second.keys()
        for key in first:
            assert_same(first[key], second[key])
    else:
        np.testing.assert_array_equal(first, second)


# --- the contracts of Gymnasium and stable-baselines3


@pytest.mark.parametrize("sensing", SENSING)
@pytest.mark.parametrize("render_mode", [None, "rgb_array"])
def test_gymnasium_accepts_it_without_a_warning(sensing: Any, render_mode: str | None) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(gym.make(ID, sensing=sensing, render_mode=render_mode).unwrapped)


@pytest.mark.parametrize("sensing", SENSING)
@pytest.mark.parametrize("wrapped", [False, True])
def test_stable_baselines3_accepts_it_without_a_warning(sensing: Any, wrapped: bool) -> None:
    checker = pytest.importorskip("stable_baselines3.common.env_checker")
    env = gym.make(ID, sensing=sensing, render_mode="rgb_array")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        checker.check_env(env if wrapped else env.unwrapped, skip_render_check=False)


def test_registered_limit_and_spaces() -> None:
    assert gym.spec(ID).max_episode_steps == 12_000
    expected = {"range": {"bearing", "range"}, "range_bearing": {"bearing", "range", "obstacle_bearing"}}
    for sensing, keys in expected.items():
        space = gym.make(ID, sensing=sensing).observation_space
        assert isinstance(space, gym.spaces.Dict)
        assert set(space) == keys
        assert all(box.shape == (1,) and box.dtype == np.float32 for box in space.values())


def test_make_vec_gives_the_native_batch() -> None:
    env = gym.make_vec(ID, num_envs=3, map="u_trap", autoreset_mode="Disabled")
    assert isinstance(env, Nav2DVectorEnv)
    assert env.max_episode_steps == 12_000
    assert env.metadata["autoreset_mode"] is AutoresetMode.DISABLED
    observation, _ = env.reset(seed=0)
    assert observation in env.observation_space


# --- seeds


@pytest.mark.parametrize("sensing", SENSING)
def test_same_seed_and_actions_give_the_same_trajectory(sensing: Any) -> None:
    actions = random_actions(300)
    first, second = (rollout(Nav2DEnv(sensing=sensing), actions, seed=5) for _ in range(2))
    np.testing.assert_array_equal(first, second)


def test_another_seed_gives_another_trajectory() -> None:
    actions = random_actions(5)
    first, second = (rollout(Nav2DEnv(map="clutter"), actions, seed=seed) for seed in (0, 1))
    assert (first != second).any()


def test_unseeded_reset_continues_the_stream() -> None:
    actions = random_actions(20)
    sequences = []
    for _ in range(2):
        env = Nav2DEnv()
        sequences.append([rollout(env, actions, seed=3), rollout(env, actions), rollout(env, actions)])
    for first, second in zip(*sequences, strict=True):
        np.testing.assert_array_equal(first, second)
    assert len({episode.tobytes() for episode in sequences[0]}) == 3


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


# --- one and many


@pytest.mark.parametrize("sensing", SENSING)
def test_vector_equals_singles(sensing: Any) -> None:
    """Resets on the next step, truncations and collisions included; the infos too."""
    options = {"sensing": sensing, "map": "mixed"}
    steps, num_envs = 400, 5
    singles = gym.vector.SyncVectorEnv(
        [lambda: gym.make(ID, max_episode_steps=150, **options) for _ in range(num_envs)]
    )
    batch = gym.make_vec(ID, num_envs=num_envs, max_episode_steps=150, **options)
    for first, second in zip(singles.reset(seed=4), batch.reset(seed=4), strict=True):
        assert_same(first, second)
    ended = 0
    push = random_actions(1, num_envs, seed=1)[0]
    for action in random_actions(steps, num_envs):
        results = singles.step(action + push), batch.step(action + push)
        for first, second in zip(*results, strict=True):
            assert_same(first, second)
        ended += int(results[0][2].sum())
    assert ended > 0


def test_disabled_autoreset_freezes_finished_ones_until_they_are_reset() -> None:
    env = Nav2DVectorEnv(num_envs=2, autoreset_mode=AutoresetMode.DISABLED, max_episode_steps=100)
    near, far = own_map([], target=(0.5, 0.0)), own_map([], target=(9.0, 0.0))
    env.reset(seed=0, options={"per_env": [near, far]})
    forward = np.tile(velocity(0.5, 0.0), (2, 1))
    rewards, terminations, truncations, positions = [], [], [], []
    for _ in range(120):
        _, reward, terminated, truncated, info = env.step(forward)
        rewards.append(reward)
        terminations.append(terminated)
        truncations.append(truncated)
        positions.append(info["position"])
    first = int(np.argmax(np.array(terminations)[:, 0]))
    assert 0 < first < 30
    assert np.array(terminations)[first:, 0].all() and not np.array(terminations)[:, 1].any()
    assert (np.array(rewards)[first + 1 :, 0] == 0.0).all()
    assert (np.array(positions)[first:, 0] == positions[first][0]).all()
    assert (np.array(truncations)[:, 1] == (np.arange(120) >= 99)).all()
    assert (np.array(positions)[99:, 1] == positions[99][1]).all()

    env.reset(options={"reset_mask": np.array([True, False]), "per_env": [near, far]})
    _, _, terminated, truncated, info = env.step(forward)
    assert terminated.tolist() == [False, False] and truncated.tolist() == [False, True]
    assert (info["position"][1] == positions[99][1]).all()


def test_vector_options_and_seeds_per_environment() -> None:
    env = Nav2DVectorEnv(num_envs=2)
    _, info = env.reset(seed=[3, None], options={"map": ["maze", "u_trap"], "map_seed": [1, 2]})
    assert info["map"].tolist() == ["maze", "u_trap_2"]
    assert info["map_seed"].tolist() == [1, 2]
    assert env.maps[0] == make_map("maze", np.random.default_rng(1))
    env.reset(options=own_map())
    assert [world.name for world in env.maps] == ["user", "user"]


def test_step_before_reset_is_an_error() -> None:
    with pytest.raises(gym.error.ResetNeeded):
        Nav2DVectorEnv(num_envs=1).step(np.zeros((1, 2), np.float32))


# --- physics


@pytest.mark.parametrize("name", MAP_NAMES)
def test_clearance_and_bearings_are_those_of_the_geometry(name: str) -> None:
    env = Nav2DEnv(map=name, sensing="range_bearing", **QUIET)
    observation, info = env.reset(seed=1)
    solid = shapely.union_all([Polygon(vertices) for vertices in env.map.obstacles])
    for action in random_actions(30):
        here = shapely.Point(info["position"])
        assert info["clearance"] == pytest.approx(solid.distance(here) - 0.1, abs=1e-9)
        assert observation["range"][0] == pytest.approx(info["clearance"], abs=1e-5)
        bearing = math.atan2(*(info["target"] - info["position"])[::-1])
        assert observation["bearing"][0] == pytest.approx(bearing, abs=1e-5)
        toward = float(observation["obstacle_bearing"][0])
        nearest = info["position"] + (info["clearance"] + 0.1) * np.array([math.cos(toward), math.sin(toward)])
        assert solid.distance(shapely.Point(nearest)) < 1e-5
        observation, _, _, _, info = env.step(action)


def test_noise_has_the_stated_size() -> None:
    env = Nav2DEnv(bearing_noise=0.05, range_noise=0.02, actuation_noise=0.03)
    _, info = env.reset(seed=0, options=own_map(target=(40.0, 0.0)))
    errors = []
    for _ in range(3000):
        before = info["position"]
        observation, _, _, _, info = env.step(np.zeros(2, np.float32))
        bearing = math.atan2(*(info["target"] - info["position"])[::-1])
        errors.append(
            [
                *(info["position"] - before) / 0.05,
                observation["bearing"][0] - bearing,
                observation["range"][0] - info["clearance"],
            ]
        )
    np.testing.assert_allclose(np.std(errors, axis=0), [0.03, 0.03, 0.05, 0.02], rtol=0.1)
    np.testing.assert_allclose(np.mean(errors, axis=0), 0.0, atol=0.004)


def test_without_noise_the_motion_is_the_command_with_its_norm_limited() -> None:
    env = Nav2DEnv(**QUIET)
    _, info = env.reset(seed=0, options=own_map([], target=(9.0, 0.0)))
    for action in random_actions(20):
        before = info["position"]
        _, _, _, _, info = env.step(action)
        limited = action * min(1.0, 0.5 / float(np.linalg.norm(action)))
        np.testing.assert_allclose(info["position"] - before, 0.05 * limited, atol=1e-7)


def test_reward_adds_up_to_the_distance_covered_and_the_arrival() -> None:
    env = Nav2DEnv()
    _, info = env.reset(seed=0, options=own_map([], target=(1.0, 0.5)))
    start, total, terminated = info["distance"], 0.0, False
    while not terminated:
        _, reward, terminated, _, info = env.step(velocity(0.8, 0.4))
        total += reward
    assert info["is_success"] and not info["collision"] and info["distance"] < 0.2
    assert total == pytest.approx(start - info["distance"] + 1.0)


def test_driving_into_a_wall_is_a_collision_and_ends_the_motion() -> None:
    env = Nav2DEnv()
    _, info = env.reset(seed=0, options=own_map())
    start, total, terminated = info["distance"], 0.0, False
    while not terminated:
        _, reward, terminated, _, info = env.step(velocity(0.5, 0.0))
        total += reward
    assert info["collision"] and not info["is_success"] and info["clearance"] <= 0.0
    assert info["position"][0] == pytest.approx(0.9, abs=0.04)
    assert total == pytest.approx(start - info["distance"] - 1.0)
    _, reward, terminated, _, after = env.step(velocity(0.5, 0.0))
    assert reward == 0.0 and terminated and (after["position"] == info["position"]).all()


def test_without_obstacles_the_range_is_the_sensors_limit() -> None:
    env = Nav2DEnv(sensing="range_bearing", max_range=5.0, **QUIET)
    observation, info = env.reset(seed=0, options=own_map([]))
    assert observation["range"] == 5.0 and info["clearance"] == 5.0 and observation["obstacle_bearing"] == 0.0


def test_repeated_vertices_change_nothing() -> None:
    repeated = [SQUARE[0], *SQUARE, SQUARE[3], SQUARE[0]]
    actions = random_actions(50)
    first, second = (rollout(Nav2DEnv(), actions, seed=0, options=own_map([polygon])) for polygon in (SQUARE, repeated))
    assert np.isfinite(first).all()
    np.testing.assert_allclose(first, second, atol=1e-9)


def test_overlapping_polygons_act_as_their_union() -> None:
    halves = [[(1, -1), (1.6, -1), (1.6, 1), (1, 1)], [(1.4, -1), (2, -1), (2, 1), (1.4, 1)]]
    actions = random_actions(50)
    first, second = (rollout(Nav2DEnv(), actions, seed=0, options=own_map(polygons)) for polygons in ([SQUARE], halves))
    np.testing.assert_allclose(first, second, atol=1e-9)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_the_action_is_left_as_it_was(dtype: Any) -> None:
    env = Nav2DEnv(map="long_wall")
    env.reset(seed=0)
    action = np.array([0.9, -0.9], dtype=dtype)
    env.step(action)
    np.testing.assert_array_equal(action, np.array([0.9, -0.9], dtype=dtype))


@settings(max_examples=25, deadline=None)
@given(name=st.sampled_from(MAP_NAMES), seed=st.integers(0, 50), heading=st.floats(-math.pi, math.pi))
def test_the_agent_enters_no_obstacle_without_a_collision(name: str, seed: int, heading: float) -> None:
    env = Nav2DEnv(map=name)
    env.reset(seed=seed)
    solid = shapely.union_all([Polygon(vertices) for vertices in env.map.obstacles])
    drift = np.array([math.cos(heading), math.sin(heading)])
    positions, collisions = [], []
    for action in random_actions(150, seed=seed):
        _, _, _, _, info = env.step(0.3 * action + drift)
        positions.append(info["position"])
        collisions.append(info["collision"])
    touches = shapely.distance(solid, shapely.points(positions)) <= 0.1
    assert (touches == np.array(collisions)).all()


@settings(max_examples=25, deadline=None)
@given(
    bearing_noise=st.floats(0.0, 10.0),
    range_noise=st.floats(0.0, 10.0),
    max_range=st.floats(0.01, 100.0),
    seed=st.integers(0, 2**32),
)
def test_observations_stay_in_their_space(
    bearing_noise: float, range_noise: float, max_range: float, seed: int
) -> None:
    physics: Any = {"bearing_noise": bearing_noise, "range_noise": range_noise, "max_range": max_range}
    env = Nav2DEnv(map="long_wall", sensing="range_bearing", **physics)
    observation, _ = env.reset(seed=seed)
    for action in random_actions(10):
        assert observation in env.observation_space
        observation, _, _, _, _ = env.step(action)


# --- errors name the argument


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
        (own_map([[(0, 0), (1, 1)]]), ["obstacles[0]"]),
        (own_map([SQUARE, [(0, 0, 0), (1, 1, 1), (2, 0, 0)]]), ["obstacles[1]"]),
        (own_map([[(5, 5), (6, 6), (6, 5), (5, 6)]]), ["obstacles[0]", "Self-intersection"]),
        (own_map([[(5, 5), (6, 6), (7, 7)]]), ["obstacles[0]"]),
        ({"obstacles": 3, "start": (0, 0), "target": (1, 0)}, ["obstacles"]),
        (own_map(start=(1.5, 0.0)), ["start", "radius"]),
        (own_map(start=(0.95, 0.0)), ["start", "radius"]),
    ],
)
def test_bad_options(options: dict[str, Any], words: list[str]) -> None:
    with pytest.raises(ValueError) as error:
        Nav2DEnv().reset(seed=0, options=options)
    assert all(word in str(error.value) for word in words), str(error.value)


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        ({"map": "nowhere"}, "u_trap_05"),
        ({"sensing": "lidar"}, "range_bearing"),
        ({"render_mode": "human"}, "rgb_array"),
        ({"range_noise": -0.1}, "range_noise"),
        ({"max_speed": 0.0}, "max_speed"),
        ({"dt": math.nan}, "dt"),
        ({"max_speed": 10.0}, "max_speed"),
    ],
)
@pytest.mark.parametrize("kind", [Nav2DEnv, Nav2DVectorEnv])
def test_bad_arguments(kind: Any, arguments: dict[str, Any], word: str) -> None:
    with pytest.raises(ValueError, match=word):
        kind(**arguments)


@pytest.mark.parametrize("kind", [Nav2DEnv, Nav2DVectorEnv])
def test_unknown_argument_lists_the_valid_ones(kind: Any) -> None:
    with pytest.raises(TypeError, match="rnge_noise.*range_noise"):
        kind(rnge_noise=0.1)


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        ({"num_envs": 0}, "num_envs"),
        ({"max_episode_steps": 0}, "max_episode_steps"),
        ({"autoreset_mode": AutoresetMode.SAME_STEP}, "NEXT_STEP"),
    ],
)
def test_bad_vector_arguments(arguments: dict[str, Any], word: str) -> None:
    with pytest.raises(ValueError, match=word):
        Nav2DVectorEnv(**arguments)


@pytest.mark.parametrize(
    ("reset", "word"),
    [
        ({"seed": [1]}, "seed"),
        ({"options": {"map": ["maze"]}}, "map"),
        ({"options": {"per_env": [{}]}}, "per_env"),
        ({"options": {"per_env": [{}, {}], "map": "maze"}}, "per_env"),
        ({"options": {"reset_mask": np.zeros(2, dtype=bool)}}, "reset_mask"),
        ({"options": {"reset_mask": [1, 0]}}, "reset_mask"),
        ({"options": {"colour": 1}}, "colour"),
    ],
)
def test_bad_vector_reset(reset: dict[str, Any], word: str) -> None:
    with pytest.raises(ValueError, match=word):
        Nav2DVectorEnv(num_envs=2).reset(**reset)


@pytest.mark.parametrize("action", [[math.nan, 0.0], [math.inf, 0.0], [0.0], [[0.0, 0.0]], 0.0])
def test_bad_action(action: Any) -> None:
    env = Nav2DEnv(map="long_wall")
    env.reset(seed=0)
    with pytest.raises(ValueError, match="action"):
        env.step(np.array(action, dtype=np.float32))


# --- pictures


def test_pictures_show_the_agent_moving() -> None:
    env = gym.make(ID, map="bug_trap", render_mode="rgb_array")
    env.reset(seed=0)
    first = env.render()
    for _ in range(20):
        env.step(velocity(0.5, 0.0))
    second = env.render()
    for picture in (first, second):
        assert isinstance(picture, np.ndarray)
        assert picture.shape == (480, 480, 3) and picture.dtype == np.uint8
    assert not np.array_equal(np.asarray(first), np.asarray(second))


def test_vector_pictures() -> None:
    env = Nav2DVectorEnv(num_envs=2, render_mode="rgb_array")
    env.reset(seed=0)
    env.step(np.zeros((2, 2), np.float32))
    assert [picture.shape for picture in env.render() or ()] == [(480, 480, 3)] * 2
    assert Nav2DVectorEnv(num_envs=1).render() is None
