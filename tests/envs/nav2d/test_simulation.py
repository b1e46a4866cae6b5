"""The physics and the sensors, against geometry and statistics."""

import math
from typing import Any

import numpy as np
import pytest
import shapely
from _nav2d_env import QUIET, SQUARE, own_map, random_actions, rollout, velocity
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely.geometry import Polygon
from shapely.geometry.base import BaseGeometry

from aicon_envs.nav2d import MAP_NAMES, Nav2DEnv


def solid_of(env: Nav2DEnv) -> BaseGeometry:
    return shapely.union_all([Polygon(vertices) for vertices in env.map.obstacles])


def angle_to_target(info: dict[str, Any]) -> float:
    x, y = info["target"] - info["position"]
    return math.atan2(y, x)


@pytest.mark.parametrize("name", MAP_NAMES)
def test_clearance_and_bearings_are_those_of_the_geometry(name: str) -> None:
    env = Nav2DEnv(map=name, sensing="range_bearing", **QUIET)
    observation, info = env.reset(seed=1)
    solid = solid_of(env)

    for action in random_actions(30):
        distance = solid.distance(shapely.Point(info["position"]))
        assert info["clearance"] == pytest.approx(distance - 0.1, abs=1e-9)
        assert observation["range"][0] == pytest.approx(info["clearance"], abs=1e-5)
        assert observation["bearing"][0] == pytest.approx(angle_to_target(info), abs=1e-5)

        # So far in the direction of the obstacle bearing, there is an obstacle.
        toward = float(observation["obstacle_bearing"][0])
        direction = np.array([math.cos(toward), math.sin(toward)])
        nearest = info["position"] + (info["clearance"] + 0.1) * direction
        assert solid.distance(shapely.Point(nearest)) < 1e-5

        observation, _, _, _, info = env.step(action)


def test_noise_has_the_stated_size() -> None:
    env = Nav2DEnv(bearing_noise=0.05, range_noise=0.02, actuation_noise=0.03)
    _, info = env.reset(seed=0, options=own_map(target=(40.0, 0.0)))

    errors = []
    for step in range(3000):
        before, action = info["position"], np.array([0.0, 0.1 * (-1) ** step], np.float32)
        observation, _, _, _, info = env.step(action)

        velocity_error = (info["position"] - before) / 0.05 - action
        bearing_error = observation["bearing"][0] - angle_to_target(info)
        range_error = observation["range"][0] - info["clearance"]
        errors.append([*velocity_error, bearing_error, range_error])

    np.testing.assert_allclose(np.std(errors, axis=0), [0.03, 0.03, 0.05, 0.02], rtol=0.1)
    np.testing.assert_allclose(np.mean(errors, axis=0), 0.0, atol=0.004)


def test_who_is_told_to_stand_stands() -> None:
    """The motors are noisy while they drive; then the brakes hold."""
    env = Nav2DEnv(actuation_noise=0.03)
    _, before = env.reset(seed=0, options=own_map(target=(40.0, 0.0)))
    for _ in range(20):
        _, _, _, _, after = env.step(np.zeros(2, np.float32))
        np.testing.assert_array_equal(after["position"], before["position"])


def test_without_noise_the_motion_is_the_command_with_its_norm_limited() -> None:
    env = Nav2DEnv(**QUIET)
    _, info = env.reset(seed=0, options=own_map([], target=(9.0, 0.0)))

    for action in random_actions(20):
        before = info["position"]
        _, _, _, _, info = env.step(action)
        limited = action * min(1.0, 0.5 / float(np.linalg.norm(action)))
        np.testing.assert_allclose(info["position"] - before, 0.05 * limited, atol=1e-7)


def test_a_command_too_large_to_be_squared_is_one_at_full_speed() -> None:
    env = Nav2DEnv(**QUIET)
    positions = []
    for speed in (1e3, 1e160, 1e308):
        env.reset(seed=0, options=own_map([]))
        positions.append(env.step(np.array([0.0, speed]))[-1]["position"])
    np.testing.assert_array_equal(positions, [positions[0]] * 3)
    assert positions[0][1] == pytest.approx(env.physics.max_speed * env.physics.dt)


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
    assert reward == 0.0 and terminated
    assert (after["position"] == info["position"]).all()


def test_without_obstacles_the_range_is_the_sensors_limit() -> None:
    env = Nav2DEnv(sensing="range_bearing", max_range=5.0, **QUIET)
    observation, info = env.reset(seed=0, options=own_map([]))

    assert observation["range"] == 5.0 and info["clearance"] == 5.0
    assert observation["obstacle_bearing"] == 0.0


def test_repeated_vertices_change_nothing() -> None:
    repeated = [SQUARE[0], *SQUARE, SQUARE[3], SQUARE[0]]
    actions = random_actions(50)

    first = rollout(Nav2DEnv(), actions, seed=0, options=own_map([SQUARE]))
    second = rollout(Nav2DEnv(), actions, seed=0, options=own_map([repeated]))
    assert np.isfinite(first).all()
    np.testing.assert_allclose(first, second, atol=1e-9)


def test_overlapping_polygons_act_as_their_union() -> None:
    halves = [[(1, -1), (1.6, -1), (1.6, 1), (1, 1)], [(1.4, -1), (2, -1), (2, 1), (1.4, 1)]]
    actions = random_actions(50)

    first = rollout(Nav2DEnv(), actions, seed=0, options=own_map([SQUARE]))
    second = rollout(Nav2DEnv(), actions, seed=0, options=own_map(halves))
    np.testing.assert_allclose(first, second, atol=1e-9)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_the_action_is_left_as_it_was(dtype: Any) -> None:
    env = Nav2DEnv(map="long_wall")
    env.reset(seed=0)

    action = np.array([0.9, -0.9], dtype=dtype)
    env.step(action)
    np.testing.assert_array_equal(action, np.array([0.9, -0.9], dtype=dtype))


@settings(max_examples=25, deadline=None)
@given(
    name=st.sampled_from(MAP_NAMES), seed=st.integers(0, 50), heading=st.floats(-math.pi, math.pi)
)
def test_the_agent_enters_no_obstacle_without_a_collision(
    name: str, seed: int, heading: float
) -> None:
    env = Nav2DEnv(map=name)
    env.reset(seed=seed)
    drift = np.array([math.cos(heading), math.sin(heading)])

    positions, collisions = [], []
    for action in random_actions(150, seed=seed):
        _, _, _, _, info = env.step(0.3 * action + drift)
        positions.append(info["position"])
        collisions.append(info["collision"])

    touches = shapely.distance(solid_of(env), shapely.points(positions)) <= 0.1
    assert (touches == np.array(collisions)).all()
