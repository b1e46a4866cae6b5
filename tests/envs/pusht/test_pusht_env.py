"""Properties of the pushT environment, alone and as a batch, and its parity with gym-pusht."""

import math
import subprocess
import sys
import warnings
from typing import Any

import gymnasium as gym
import numpy as np
import pymunk
import pytest
import shapely
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from shapely.geometry import Polygon

import aicon_envs  # noqa: F401  (registers the environments)
from aicon_envs.pusht import OBJECTS, Overlay, PushTEnv, PushTVectorEnv
from aicon_envs.pusht.geometry import overlap_area, place
from aicon_envs.pusht.simulation import PUSHER_RADIUS, WALL_HIGH, WALL_LOW

ID = "aicon/PushT-v0"
OBS_TYPES = ("environment_state_agent_pos", "state", "pixels", "pixels_agent_pos")
GOAL = (256.0, 256.0, math.pi / 4.0)
APART = [40.0, 40.0, 300.0, 200.0, 0.3]
DISTURBED: Any = {
    "goal_pose": "random",
    "observe_goal": True,
    "action_noise": 2.0,
    "goal_jumps": 2,
    "goal_jump_interval": (5, 20),
    "kick_interval": 7,
}


def random_actions(steps: int, *shape: int, seed: int = 0) -> NDArray[np.float32]:
    return np.random.default_rng(seed).uniform(0.0, 512.0, size=(steps, *shape, 2)).astype(np.float32)


def push(info: dict[str, Any], noise: NDArray[np.float64]) -> NDArray[np.float32]:
    """A target near the object's frame: the pusher runs into the object from all sides."""
    target: NDArray[np.float32] = (info["block_pose"][:2] + 60.0 * noise).clip(0.0, 512.0).astype(np.float32)
    return target


def pushes(steps: int, seed: int = 0) -> NDArray[np.float64]:
    return np.random.default_rng(seed).normal(size=(steps, 2))


def assert_same(first: Any, second: Any, tolerance: float = 0.0) -> None:
    """Observations, infos and other results agree."""
    if isinstance(first, dict):
        assert first.keys() == second.keys()
        for key in first:
            assert_same(first[key], second[key], tolerance)
    else:
        np.testing.assert_allclose(first, second, rtol=0.0, atol=tolerance)


def rollout(env: PushTEnv, steps: int = 30, **reset: Any) -> list[Any]:
    observation, info = env.reset(**reset)
    record: list[Any] = [observation, info]
    for noise in pushes(steps):
        observation, reward, terminated, _, info = env.step(push(info, noise))
        record += [observation, reward, terminated, info]
    return record


# --- parity with gym-pusht


@pytest.fixture
def upstream() -> Any:
    pytest.importorskip("gym_pusht")

    def make(**arguments: Any) -> Any:
        return gym.make("gym_pusht/PushT-v0", **arguments).unwrapped

    return make


@pytest.mark.parametrize("seed", range(6))
def test_episodes_are_those_of_gym_pusht(upstream: Any, seed: int) -> None:
    theirs, ours = upstream(obs_type="environment_state_agent_pos"), PushTEnv()
    contacts = 0
    for kind in (push, lambda info, noise: (256.0 + 100.0 * noise).clip(0.0, 512.0)):
        (expected, their_info), (observation, info) = theirs.reset(seed=seed), ours.reset(seed=seed)
        for noise in pushes(300, seed):
            assert_same(expected, observation, 1e-9)
            assert_same(their_info, {key: info[key] for key in their_info}, 1e-9)
            action = kind(their_info, noise).astype(np.float32)
            expected, *their_results, their_info = theirs.step(action)
            observation, *results, info = ours.step(action)
            np.testing.assert_allclose(their_results, results, rtol=0.0, atol=1e-9)
            contacts += info["n_contacts"]
    assert contacts > 10


def test_later_starts_without_a_seed_are_those_of_gym_pusht(upstream: Any) -> None:
    theirs, ours = upstream(obs_type="state"), PushTEnv(obs_type="state", action_noise=3.0, kick_interval=2)
    for seed in (7, None, None, None):
        assert_same(theirs.reset(seed=seed)[0], ours.reset(seed=seed)[0], 1e-9)
        for action in random_actions(5):
            ours.step(action)


@pytest.mark.parametrize("obs_type", ["pixels", "pixels_agent_pos"])
def test_pictures_are_those_of_gym_pusht(upstream: Any, obs_type: Any) -> None:
    """Number for number, though gym-pusht resizes with OpenCV and we do not."""
    theirs, ours = upstream(obs_type=obs_type), PushTEnv(obs_type=obs_type)
    for seed in range(4):
        expected, info = theirs.reset(seed=seed)
        observation, _ = ours.reset(seed=seed)
        for noise in pushes(40, seed):
            assert_same(expected, observation)
            action = push(info, noise)
            expected, _, _, _, info = theirs.step(action)
            observation, _, _, _, _ = ours.step(action)


def test_rendering_is_that_of_gym_pusht_but_for_rounding(upstream: Any) -> None:
    theirs, ours = upstream(render_mode="rgb_array"), PushTEnv(render_mode="rgb_array")
    theirs.reset(seed=1), ours.reset(seed=1)
    difference = np.abs(theirs.render().astype(int) - np.asarray(ours.render()).astype(int))
    assert difference.max() <= 1


@pytest.mark.parametrize("obs_type", OBS_TYPES)
def test_spaces_are_those_of_gym_pusht(upstream: Any, obs_type: Any) -> None:
    theirs, ours = upstream(obs_type=obs_type), PushTEnv(obs_type=obs_type)
    assert theirs.observation_space == ours.observation_space
    assert theirs.action_space == ours.action_space


def test_legacy_reset_sets_what_gym_pusht_sets(upstream: Any) -> None:
    options = {"reset_to_state": [100.0, 110.0, 220.0, 330.0, 1.0]}
    theirs, ours = upstream(), PushTEnv(obs_type="state", legacy_reset=True)
    assert_same(theirs.reset(options=options)[0], ours.reset(options=options)[0], 1e-9)


def test_starts_of_version_0_1_5() -> None:
    """By the formula in that version, whose state is set as in 0.1.8."""
    env = PushTEnv(obs_type="state", start_distribution="0.1.5")
    for seed in range(20):
        old = np.random.RandomState(seed)
        state = [*old.randint(50, 450, 2), *old.randint(100, 400, 2), old.randn() * 2 * np.pi - np.pi]
        legacy = PushTEnv(obs_type="state", legacy_reset=True)
        assert_same(legacy.reset(options={"reset_to_state": state})[0], env.reset(seed=seed)[0], 1e-12)
    repeated = []
    for _ in range(2):
        env.reset(seed=3)
        repeated.append(env.reset()[0])
    assert_same(*repeated)


# --- the contracts of Gymnasium and stable-baselines3


def _only_advice_on_scaling(check: Any, env: Any) -> None:
    """Targets in px are not normalised, as in gym-pusht; every other warning is an error."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", message=".*symmetric and normalized")
        check(env)


@pytest.mark.parametrize("mode", ["position", "velocity"])
@pytest.mark.parametrize("obs_type", OBS_TYPES)
def test_gymnasium_accepts_it_without_a_warning(obs_type: Any, mode: str) -> None:
    env = gym.make(ID, obs_type=obs_type, action_mode=mode, render_mode="rgb_array", visualization_width=64)
    _only_advice_on_scaling(check_env, env.unwrapped)


@pytest.mark.parametrize("obs_type", OBS_TYPES)
def test_stable_baselines3_accepts_it_without_a_warning(obs_type: Any) -> None:
    checker = pytest.importorskip("stable_baselines3.common.env_checker")
    env = gym.make(ID, obs_type=obs_type, render_mode="rgb_array", visualization_width=64, visualization_height=64)
    _only_advice_on_scaling(checker.check_env, env.unwrapped)


@pytest.mark.parametrize("object", OBJECTS)
def test_observations_of_a_disturbed_variant_stay_in_their_space(object: str) -> None:
    for mode in ("position", "velocity"):
        env = PushTEnv(object=object, action_mode=mode, velocity_limit=900.0, **DISTURBED)
        observation, _ = env.reset(seed=1)
        for action in random_actions(60, seed=2):
            assert observation in env.observation_space
            observation, reward, _, _, info = env.step(action if mode == "position" else 10.0 * (action - 256.0))
            assert 0.0 <= reward <= 1.0
            assert info["goal_pose"] == pytest.approx(observation["goal_pose"])


def test_registered_limit_and_default_observation() -> None:
    assert gym.spec(ID).max_episode_steps == 300
    space = gym.make(ID).observation_space
    assert isinstance(space, gym.spaces.Dict) and set(space) == {"environment_state", "agent_pos"}


def test_make_vec_gives_the_native_batch() -> None:
    env = gym.make_vec(ID, num_envs=3, object="L", autoreset_mode="Disabled")
    assert isinstance(env, PushTVectorEnv)
    assert env.max_episode_steps == 300
    assert env.metadata["autoreset_mode"] is AutoresetMode.DISABLED
    observation, _ = env.reset(seed=0)
    assert observation in env.observation_space


@pytest.mark.parametrize(
    ("missing", "code"),
    [
        ("pymunk", 'gym.make("aicon/PushT-v0")'),
        ("pygame", 'gym.make("aicon/PushT-v0", obs_type="pixels").reset()'),
    ],
)
def test_a_missing_extra_is_named(missing: str, code: str) -> None:
    start = f"import sys; sys.modules[{missing!r}] = None; import gymnasium as gym; import aicon_envs; "
    result = subprocess.run([sys.executable, "-c", start + code], capture_output=True, text=True, check=False)
    assert 'pip install "aicon-torch[pusht]"' in result.stderr, result.stderr


def test_without_pictures_nothing_needs_pygame() -> None:
    code = (
        "import sys; sys.modules['pygame'] = sys.modules['cv2'] = None; import gymnasium as gym; import aicon_envs; "
        "env = gym.make('aicon/PushT-v0'); env.reset(seed=0); env.step(env.action_space.sample())"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


# --- seeds


@pytest.mark.parametrize("arguments", [{}, DISTURBED, {"start_distribution": "0.1.5"}])
def test_same_seed_and_actions_give_the_same_episode(arguments: Any) -> None:
    first, second = (rollout(PushTEnv(**arguments), seed=5) for _ in range(2))
    for each in zip(first, second, strict=True):
        assert_same(*each)


def test_a_used_environment_gives_the_same_episode_as_a_fresh_one() -> None:
    env = PushTEnv(**DISTURBED)
    rollout(env, seed=3)
    for each in zip(rollout(env, seed=5), rollout(PushTEnv(**DISTURBED), seed=5), strict=True):
        assert_same(*each)


def test_options_leave_the_start_as_it_is() -> None:
    (plain, _), (disturbed, _) = PushTEnv().reset(seed=4), PushTEnv(**DISTURBED).reset(seed=4)
    for key in plain:
        assert_same(plain[key], disturbed[key])


def test_noise_seed_changes_the_noise_and_nothing_else() -> None:
    env = PushTEnv(**DISTURBED)
    first, again, other = (rollout(env, seed=4, options={"noise_seed": noise}) for noise in (1, 1, 2))
    for each in zip(first, again, strict=True):
        assert_same(*each)
    assert_same(first[0], other[0])
    assert_same([info["goal_pose"] for info in first[5::4]], [info["goal_pose"] for info in other[5::4]])
    assert (first[-1]["pos_agent"] != other[-1]["pos_agent"]).any()


# --- starts and goals


@given(
    x=st.floats(120.0, 390.0), y=st.floats(120.0, 390.0), angle=st.floats(-7.0, 7.0), object=st.sampled_from([*OBJECTS])
)
def test_a_given_state_is_set_exactly(x: float, y: float, angle: float, object: str) -> None:
    env = PushTEnv(object=object, goal_pose=(x, y, math.remainder(angle, math.tau)))
    _, info = env.reset(options={"reset_to_state": [30.0, 500.0, x, y, angle]})
    np.testing.assert_allclose(info["pos_agent"], [30.0, 500.0], atol=0.0)
    np.testing.assert_allclose(info["block_pose"], [x, y, angle], atol=1e-9)
    assert info["coverage"] == pytest.approx(1.0) and info["pose_error"] == pytest.approx(0.0, abs=1e-9)
    assert not info["is_success"]
    _, reward, terminated, _, info = env.step(np.array([30.0, 500.0], np.float32))
    assert terminated and info["is_success"] and reward == 1.0


@pytest.mark.parametrize("object", OBJECTS)
def test_random_goals_fit_between_the_walls(object: str) -> None:
    env = PushTEnv(object=object, goal_pose="random")
    goals = [env.reset(seed=seed)[1]["goal_pose"] for seed in range(200)]
    corners = np.array([place(env.object.keypoints, tuple(goal)) for goal in goals])
    assert corners.min() >= WALL_LOW and corners.max() <= WALL_HIGH
    assert corners.min() < WALL_LOW + 10.0 and corners.max() > WALL_HIGH - 10.0
    angles = np.array(goals)[:, 2]
    assert angles.min() < -3.0 and angles.max() > 3.0


def test_goal_of_one_reset() -> None:
    env = PushTEnv(observe_goal=True)
    observation, info = env.reset(seed=0, options={"goal_pose": (100.0, 200.0, -1.0)})
    assert observation["goal_pose"].tolist() == info["goal_pose"].tolist() == [100.0, 200.0, -1.0]
    assert env.reset(seed=0, options={"goal_pose": "random"})[1]["goal_pose"].tolist() != list(GOAL)
    assert env.reset(seed=0)[1]["goal_pose"].tolist() == list(GOAL)


def test_goal_jumps_put_success_off_until_the_last() -> None:
    env = PushTEnv(goal_jumps=2, goal_jump_interval=(3, 5))
    stay = np.array(APART[:2], np.float32)
    for seed in range(5):
        _, info = env.reset(seed=seed, options={"reset_to_state": [*APART[:2], *GOAL]})
        goals, waits = [tuple(info["goal_pose"])], [0]
        for step in range(15):
            before = info["goal_pose"]
            _, reward, terminated, _, info = env.step(stay)
            assert not terminated
            if (info["goal_pose"] != before).any():
                goals.append(tuple(info["goal_pose"]))
                waits.append(step)
            assert (reward == 1.0) == (len(goals) == 1)
        assert len(set(goals)) == 3 and all(3 <= wait <= 5 for wait in np.diff(waits))


# --- coverage and pose error


@given(
    dx=st.floats(-150.0, 150.0),
    dy=st.floats(-150.0, 150.0),
    angle=st.floats(-4.0, 4.0),
    name=st.sampled_from([*OBJECTS]),
)
def test_coverage_is_the_share_of_the_area_in_the_goal(dx: float, dy: float, angle: float, name: str) -> None:
    env = PushTEnv(object=name)
    _, info = env.reset(options={"reset_to_state": [*APART[:2], 256.0 + dx, 256.0 + dy, angle]})
    block, goal = (Polygon(place(env.object.outline, tuple(info[key]))) for key in ("block_pose", "goal_pose"))
    assert info["coverage"] == pytest.approx(block.intersection(goal).area / goal.area, abs=1e-9)


@given(scale=st.floats(-12.0, 2.0), seed=st.integers(0, 1000))
def test_overlap_of_polygons_that_almost_coincide(scale: float, seed: int) -> None:
    shift = 10.0**scale * np.random.default_rng(seed).normal(size=2)
    square = np.array([(0.0, 0.0), (50.0, 10.0), (40.0, 60.0), (-10.0, 50.0)])
    expected = shapely.intersection(Polygon(square), Polygon(square + shift)).area
    assert overlap_area((square + shift).tolist(), square.tolist()) == pytest.approx(expected, abs=1e-9)


def test_pose_error_weighs_a_turn_by_the_radius_of_gyration() -> None:
    for name, thing in OBJECTS.items():
        env = PushTEnv(object=name, goal_pose=(256.0, 256.0, 0.0))
        _, info = env.reset(options={"reset_to_state": [*APART[:2], 259.0, 252.0, 0.0]})
        assert info["pose_error"] == pytest.approx(5.0)
        turn = np.array(thing.center_of_gravity) - place(np.array([thing.center_of_gravity]), (0.0, 0.0, 2.0))[0]
        _, info = env.reset(options={"reset_to_state": [*APART[:2], *(turn + 256.0), 2.0]})
        assert info["pose_error"] == pytest.approx(2.0 * thing.radius_of_gyration)


# --- actions


def test_velocity_mode_moves_with_exactly_the_velocity_of_limited_norm() -> None:
    env = PushTEnv(action_mode="velocity", velocity_limit=300.0)
    assert env.action_space == gym.spaces.Box(-300.0, 300.0, (2,), np.float32)
    _, info = env.reset(options={"reset_to_state": [256.0, 256.0, 100.0, 100.0, 0.0]})
    for velocity in np.random.default_rng(0).uniform(-300.0, 300.0, (10, 2)):
        before = info["pos_agent"]
        _, _, _, _, info = env.step(velocity)
        expected = velocity * min(1.0, 300.0 / float(np.linalg.norm(velocity)))
        np.testing.assert_allclose(info["pos_agent"] - before, 0.1 * expected, atol=1e-9)
        np.testing.assert_allclose(info["vel_agent"], expected, rtol=1e-6)


def test_the_pusher_stays_in_the_world() -> None:
    env = PushTEnv(action_mode="velocity", action_noise=5.0)
    env.reset(seed=0)
    for velocity in ([400.0, 0.0], [0.0, 400.0], [-400.0, -400.0]):
        for _ in range(20):
            observation, _, _, _, _ = env.step(np.array(velocity, np.float32))
            assert observation["agent_pos"].min() >= -1e-9 and observation["agent_pos"].max() <= 512.0 + 1e-9
    env = PushTEnv()
    env.reset(options={"reset_to_state": APART})
    for _ in range(50):
        observation, _, _, _, _ = env.step(np.array([-1e6, 40.0]))
    assert observation["agent_pos"] == pytest.approx([0.0, 40.0], abs=1e-3)


@pytest.mark.parametrize("limit", [50.0, 200.0])
def test_velocity_limit_holds_in_position_mode(limit: float) -> None:
    env = PushTEnv(velocity_limit=limit)
    _, info = env.reset(options={"reset_to_state": APART})
    target = np.array([400.0, 500.0], np.float32)
    speeds = []
    for _ in range(5):
        before = info["pos_agent"]
        _, _, _, _, info = env.step(target)
        speeds.append(float(np.linalg.norm(info["pos_agent"] - before)) / 0.1)
    assert max(speeds) <= limit + 1e-9 and speeds[-1] == pytest.approx(limit)


@pytest.mark.parametrize("mode", ["position", "velocity"])
def test_action_noise_has_the_stated_size(mode: str) -> None:
    env = PushTEnv(action_mode=mode, action_noise=3.0, velocity_limit=1e4)
    quiet = PushTEnv(action_mode=mode, velocity_limit=1e4)
    action = np.array([256.0, 256.0] if mode == "position" else [0.0, 0.0], np.float32)
    # From rest, the PD controller covers a fixed share of the target offset in one step.
    options = {"reset_to_state": [156.0, 256.0, 400.0, 100.0, 0.0]}
    _, info = quiet.reset(options=options)
    _, _, _, _, moved = quiet.step(action)
    share = (moved["pos_agent"] - info["pos_agent"])[0] / 100.0 if mode == "position" else 1.0
    errors = []
    for seed in range(400):
        env.reset(seed=seed, options=options)
        errors.append((env.step(action)[4]["pos_agent"] - moved["pos_agent"]) / share)
    np.testing.assert_allclose(np.std(errors, axis=0), 3.0, rtol=0.1)
    np.testing.assert_allclose(np.mean(errors, axis=0), 0.0, atol=0.5)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_the_action_is_left_as_it_was(dtype: Any) -> None:
    env = PushTEnv()
    env.reset(seed=0)
    action = np.array([0.9, 510.0], dtype=dtype)
    env.step(action)
    np.testing.assert_array_equal(action, np.array([0.9, 510.0], dtype=dtype))


# --- kicks


@pytest.mark.parametrize("object", OBJECTS)
def test_kicks_come_on_time_within_their_size_and_leave_the_object_free(object: str) -> None:
    env = PushTEnv(object=object, kick_interval=4, kick=(40.0, 0.6), goal_pose=(400.0, 400.0, 0.0))
    stay = np.array(APART[:2], np.float32)
    gravity = np.array([env.object.center_of_gravity])
    moved = []
    for seed in range(30):
        _, info = env.reset(seed=seed, options={"reset_to_state": APART})
        for step in range(1, 14):
            before = info["block_pose"]
            _, _, _, _, info = env.step(stay)
            pose = info["block_pose"]
            shift = np.linalg.norm(place(gravity, tuple(pose)) - place(gravity, tuple(before)))
            if step % 4 == 1 and step > 1:
                assert shift <= 40.0 + 1e-9 and abs(pose[2] - before[2]) <= 0.6 + 1e-9
                moved.append(shift)
            else:
                assert shift < 1e-9
            outline = Polygon(place(env.object.outline, tuple(pose)))
            assert outline.distance(shapely.Point(info["pos_agent"])) >= PUSHER_RADIUS
            assert min(outline.bounds) >= WALL_LOW and max(outline.bounds) <= WALL_HIGH
    assert np.mean(moved) > 15.0


# --- one and many


@pytest.mark.parametrize("arguments", [{}, {"obs_type": "state"}, {"obs_type": "pixels"}, DISTURBED])
def test_vector_equals_singles(arguments: Any) -> None:
    """Resets on the next step, truncations and successes included; the infos too."""
    steps, num_envs, limit = 40, 3, 17
    singles = gym.vector.SyncVectorEnv(
        [lambda: gym.make(ID, max_episode_steps=limit, **arguments) for _ in range(num_envs)]
    )
    batch = gym.make_vec(ID, num_envs=num_envs, max_episode_steps=limit, **arguments)
    options = {"reset_to_state": [*APART[:2], *GOAL]}
    results: list[Any] = [env.reset(seed=4, options=options) for env in (singles, batch)]
    ended = 0
    for action in random_actions(steps, num_envs):
        *firsts, first_info = results[0]
        *seconds, second_info = results[1]
        for first, second in zip(firsts, seconds, strict=True):
            assert_same(first, second)
        assert_same(first_info, {key: second_info[key] for key in first_info})
        results = [singles.step(action), batch.step(action)]
        ended += results[0][2].sum() + results[0][3].sum()
    assert ended >= (2 if "goal_jumps" in arguments else 3) * num_envs


def test_disabled_autoreset_freezes_finished_ones_until_they_are_reset() -> None:
    env = PushTVectorEnv(num_envs=2, autoreset_mode=AutoresetMode.DISABLED, max_episode_steps=10)
    solved = {"reset_to_state": [*APART[:2], *GOAL]}
    env.reset(options={"per_env": [solved, {"reset_to_state": APART}]})
    action = np.full((2, 2), 100.0)
    positions, rewards = [], []
    for step in range(1, 14):
        _, reward, terminated, truncated, info = env.step(action)
        assert terminated.tolist() == [True, False] and truncated.tolist() == [False, step >= 10]
        assert info["is_success"].tolist() == [True, False] and not info["collision"].any()
        positions.append(info["position"])
        rewards.append(reward[0])
    assert rewards == [1.0] + [0.0] * 12
    assert (np.array(positions)[:, 0] == positions[0][0]).all()
    assert (np.array(positions)[9:, 1] == positions[9][1]).all() and (positions[8][1] != positions[9][1]).any()

    _, info = env.reset(options={"reset_mask": np.array([False, True]), "per_env": [{}, {"reset_to_state": APART}]})
    assert info["_position"].tolist() == [False, True] and (info["position"][0] == positions[0][0]).all()
    _, _, terminated, truncated, _ = env.step(action)
    assert terminated.tolist() == [True, False] and truncated.tolist() == [False, False]


def test_vector_infos_have_the_names_of_the_evaluation() -> None:
    env = PushTVectorEnv(num_envs=3, object="U")
    _, info = env.reset(seed=[3, None, 5])
    shapes = {"is_success": (3,), "coverage": (3,), "position": (3, 2), "distance": (3,), "collision": (3,)}
    shapes |= {"block_pose": (3, 3), "goal_pose": (3, 3)}
    assert {key: info[key].shape for key in shapes} == shapes
    single = PushTEnv(object="U")
    _, expected = single.reset(seed=5)
    assert info["distance"][2] == expected["pose_error"]
    assert info["position"][2].tolist() == expected["pos_agent"].tolist()


def test_step_before_reset_is_an_error() -> None:
    with pytest.raises(gym.error.ResetNeeded):
        PushTVectorEnv(num_envs=1).step(np.zeros((1, 2), np.float32))
    with pytest.raises(gym.error.ResetNeeded):
        PushTEnv().step(np.zeros(2, np.float32))


# --- errors name the argument


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"obs_type": "keypoints"}, ["obs_type", "environment_state_agent_pos", "pixels"]),
        ({"obs_type": "state", "observe_goal": True}, ["observe_goal", "environment_state_agent_pos"]),
        ({"render_mode": "human"}, ["render_mode", "rgb_array"]),
        ({"object": "W"}, ["object", "quadrilateral", "vertices"]),
        ({"object": [(0, 0), (1, 1)]}, ["polygon"]),
        ({"goal_pose": (1, 2)}, ["goal_pose", "rad"]),
        ({"goal_pose": (600, 2, 0)}, ["goal_pose", "512"]),
        ({"goal_pose": "anywhere"}, ["goal_pose"]),
        ({"action_mode": "force"}, ["action_mode", "velocity"]),
        ({"action_noise": -1.0}, ["action_noise", ">= 0"]),
        ({"action_noise": "much"}, ["action_noise"]),
        ({"velocity_limit": 0.0}, ["velocity_limit", "> 0"]),
        ({"velocity_limit": math.inf}, ["velocity_limit"]),
        ({"goal_jumps": -1}, ["goal_jumps"]),
        ({"goal_jump_interval": (5, 4)}, ["goal_jump_interval"]),
        ({"goal_jump_interval": 5}, ["goal_jump_interval"]),
        ({"kick_interval": 0}, ["kick_interval", ">= 1"]),
        ({"kick": 3.0}, ["kick", "rad"]),
        ({"kick": (3.0, -1.0)}, ["kick"]),
        ({"start_distribution": "0.1.6"}, ["start_distribution", "0.1.5"]),
        ({"observation_width": 0}, ["observation_width"]),
        ({"visualization_height": 1.5}, ["visualization_height"]),
    ],
)
@pytest.mark.parametrize("kind", [PushTEnv, PushTVectorEnv])
def test_bad_arguments(kind: Any, arguments: dict[str, Any], words: list[str]) -> None:
    with pytest.raises(ValueError) as error:
        kind(**arguments)
    assert all(word in str(error.value) for word in words), str(error.value)


@pytest.mark.parametrize("kind", [PushTEnv, PushTVectorEnv])
def test_unknown_argument_lists_the_valid_ones(kind: Any) -> None:
    with pytest.raises(TypeError, match="acton_noise.*action_noise"):
        kind(acton_noise=0.1)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"state": APART}, ["state", "reset_to_state", "goal_pose", "noise_seed"]),
        ({"reset_to_state": [0.0, 1.0]}, ["reset_to_state", "angle"]),
        ({"reset_to_state": [0.0, 1.0, 2.0, 3.0, math.nan]}, ["reset_to_state"]),
        ({"reset_to_state": [-1.0, 1.0, 2.0, 3.0, 0.0]}, ["reset_to_state", "512"]),
        ({"goal_pose": [0.0, 0.0, 10.0]}, ["goal_pose", "2π"]),
        ({"noise_seed": -1}, ["noise_seed"]),
    ],
)
def test_bad_options(options: dict[str, Any], words: list[str]) -> None:
    with pytest.raises(ValueError) as error:
        PushTEnv().reset(seed=0, options=options)
    assert all(word in str(error.value) for word in words), str(error.value)


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
        PushTVectorEnv(**arguments)


@pytest.mark.parametrize(
    ("reset", "word"),
    [
        ({"seed": [1]}, "seed"),
        ({"options": {"per_env": [{}]}}, "per_env"),
        ({"options": {"per_env": [{}, {}], "goal_pose": "random"}}, "per_env"),
        ({"options": {"reset_mask": np.zeros(2, dtype=bool)}}, "reset_mask"),
        ({"options": {"reset_mask": [1, 0]}}, "reset_mask"),
        ({"options": {"colour": 1}}, "colour"),
    ],
)
def test_bad_vector_reset(reset: dict[str, Any], word: str) -> None:
    with pytest.raises(ValueError, match=word):
        PushTVectorEnv(num_envs=2).reset(**reset)


@pytest.mark.parametrize("action", [[math.nan, 0.0], [math.inf, 0.0], [0.0], [[0.0, 0.0]], 0.0])
def test_bad_action(action: Any) -> None:
    env, batch = PushTEnv(), PushTVectorEnv(num_envs=2)
    env.reset(seed=0), batch.reset(seed=0)
    for each in (env, batch):
        with pytest.raises(ValueError, match="action"):
            each.step(np.array(action, dtype=np.float32))


# --- pictures


def test_overlay_and_target_are_in_renderings_only() -> None:
    env = PushTEnv(obs_type="pixels", render_mode="rgb_array", visualization_width=200, visualization_height=100)
    pixels, _ = env.reset(seed=0)
    plain = env.render()
    assert plain is not None and plain.shape == (100, 200, 3) and plain.dtype == np.uint8
    env.overlay = Overlay(arrows=[(100, 100, 50, 20, (1, 2, 3))], points=[(400, 400, (4, 5, 6))], text="exploring")
    drawn = env.render()
    assert drawn is not None
    for color in ((1, 2, 3), (4, 5, 6)):
        assert (drawn == color).all(axis=-1).any() and not (plain == color).all(axis=-1).any()
    assert_same(env.reset(seed=0)[0], pixels)


def test_pictures_show_other_objects() -> None:
    pictures = []
    for name in OBJECTS:
        env = PushTEnv(object=name, render_mode="rgb_array")
        env.reset(options={"reset_to_state": APART})
        pictures.append(np.asarray(env.render()).tobytes())
    assert len(set(pictures)) == len(OBJECTS)


def test_vector_pictures() -> None:
    env = PushTVectorEnv(num_envs=2, render_mode="rgb_array")
    env.reset(seed=0)
    assert [picture.shape for picture in env.render() or ()] == [(680, 680, 3)] * 2
    assert PushTVectorEnv(num_envs=1).render() is None


def test_pymunk_is_of_the_major_version_whose_physics_are_compared() -> None:
    assert pymunk.version.split(".")[0] == "6"
