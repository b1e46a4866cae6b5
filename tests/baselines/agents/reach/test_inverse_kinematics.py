"""Damped least squares, mink, pink and placo, as baselines of reaching."""

import pickle
import re
from typing import Any

import numpy as np
import pytest

pytest.importorskip("mujoco")
pytest.importorskip("trimesh")

import mujoco

from aicon_baselines.agents import factory, opponents
from aicon_baselines.agents.reach import Mink
from aicon_baselines.agents.reach.kinematics import rotation_vector, target_rotation
from aicon_baselines.evaluation import ComparisonError
from aicon_baselines.tasks.reach import TASK
from aicon_torch.errors import OptionError

NAMES = ["damped_least_squares", "mink", "pink", "placo"]
HOME = np.array([0.0, -1.571, 1.571, -1.571, -1.571, 0.0])


def make(name: str, condition: str = "ur5_pose_home", **options: Any) -> Any:
    if name != "damped_least_squares":
        pytest.importorskip(name)
    return factory("reach", name, **options)(condition)


def observation(joints: np.ndarray, target: np.ndarray, agent: Any) -> dict[str, np.ndarray]:
    """What the environment says where the tip should be as at other joints."""
    agent.kinematics.move(target)
    position, rotation = agent.kinematics.tip()
    env = TASK.make_env(1, "ur5_pose_home", 5)
    seen, _ = env.reset(seed=[0])
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, rotation.ravel())
    return {
        **seen,
        "q": joints[None],
        "target_position": position[None],
        "target_orientation": quaternion[None],
    }


@pytest.mark.parametrize("name", NAMES)
def test_it_goes_to_a_target_nearby(name: str) -> None:
    agent, joints = make(name), HOME.copy()
    there = HOME + np.array([0.2, -0.1, 0.15, 0.1, -0.2, 0.3])
    seen = observation(joints, there, agent)

    for _ in range(200):
        action, _ = agent.predict({**seen, "q": joints[None]})
        joints = joints + 0.02 * action[0]
    np.testing.assert_allclose(joints, there, atol=0.01)


@pytest.mark.parametrize("name", NAMES)
def test_it_keeps_speeds_and_stops(name: str) -> None:
    agent, joints = make(name), HOME.copy()
    joints[5] = 3.0
    there = joints.copy()
    there[5] = 3.14  # nearer to its stop than allowed
    seen = observation(joints, there, agent)

    for _ in range(100):
        action, _ = agent.predict({**seen, "q": joints[None]})
        assert (np.abs(action) <= 1.5 + 1e-6).all()
        joints = joints + 0.02 * action[0]
        assert joints[5] <= np.pi - 0.02 + 1e-6


@pytest.mark.parametrize("name", NAMES[1:])
def test_it_does_not_touch_itself(name: str) -> None:
    agent = make(name)
    folded = np.array([0.0, -1.5, 2.9, -1.5, 0.0, 0.0])
    joints = folded + np.array([0.0, 0.0, -0.8, 0.0, 0.0, 0.0])
    seen = observation(joints, folded, agent)
    env = TASK.make_env(1, "ur5_pose_home", 5)
    simulation, last = env.envs[0].unwrapped._simulation, 0.05

    for _ in range(100):
        action, _ = agent.predict({**seen, "q": joints[None]})
        joints = joints + 0.02 * action[0]
        gap = simulation.measure(joints, np.zeros((0, 3))).to_itself
        assert gap > 0.009
        if last < 0.05 and name == "mink":
            assert gap - 0.01 >= 0.85 * (last - 0.01) - 1e-4  # the damper
        last = gap
    assert last < 0.03


@pytest.mark.parametrize("name", NAMES)
def test_episodes_of_a_batch_are_on_their_own(name: str) -> None:
    agent = make(name)
    env = TASK.make_env(3, "ur5_pose_random", 5)
    seen, _ = env.reset(seed=[0, 1, 2])
    together, _ = agent.predict(seen)
    for row in range(3):
        alone, _ = agent.predict({key: values[[row]] for key, values in seen.items()})
        np.testing.assert_allclose(alone[0], together[row], atol=1e-9)


@pytest.mark.parametrize(
    "condition", ["ur5_position_home", pytest.param("so101_axis_home", marks=pytest.mark.slow)]
)
def test_of_the_orientation_only_what_counts_is_missing(condition: str) -> None:
    """Where nothing else is missing, nothing moves."""
    agent = make("damped_least_squares", condition)
    env = TASK.make_env(1, condition, 5)
    seen, _ = env.reset(seed=[0])
    one = env.envs[0].unwrapped
    seen["q"] = one._episode.target_joints[None]
    action, _ = agent.predict(seen)
    np.testing.assert_allclose(action, 0.0, atol=1e-6)


def test_the_shortest_turn_takes_one_axis_to_the_other() -> None:
    generator = np.random.default_rng(0)
    for _ in range(20):
        now, _ = np.linalg.qr(generator.normal(size=(3, 3)))
        now *= np.sign(np.linalg.det(now))
        axis = generator.normal(size=3)
        axis /= np.linalg.norm(axis)
        turned = target_rotation("axis", {"target_orientation": axis}, now)
        np.testing.assert_allclose(turned[:, 2], axis, atol=1e-9)

        turn = rotation_vector(turned @ now.T)
        expected = np.arccos(now[:, 2] @ axis)
        assert np.linalg.norm(turn) == pytest.approx(expected)

    opposite = target_rotation("axis", {"target_orientation": -now[:, 2]}, now)
    np.testing.assert_allclose(opposite[:, 2], -now[:, 2], atol=1e-9)


def test_what_builds_them_can_be_sent_to_a_worker() -> None:
    build = factory("reach", "damped_least_squares", gain=2.0)
    assert pickle.loads(pickle.dumps(build)) == build
    assert build("ur5_position_home").gain == 2.0


def test_they_are_told_the_condition() -> None:
    agent = make("damped_least_squares", "panda_position_home_fast")
    assert agent.orientation == "free" and agent.speed == 3.0 and agent.tip == "panda_hand_tcp"
    assert make("damped_least_squares", "ur5_pose_home_ball").balls == 1


def test_mink_says_what_it_needs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Mink, "modules", ("no_such_module",))
    with pytest.raises(ComparisonError, match=r"pip install 'aicon-torch\[peers\]'"):
        factory("reach", "mink")
    assert {"damped_least_squares", "mink"} <= set(opponents("reach"))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"orientation": "pose"}, "orientation='pose': expected one of 'free', 'axis', 'full'"),
        ({"speed": -1.0}, "speed=-1.0: expected a positive number"),
        ({"gain": np.nan}, "gain=nan: expected 1 finite number"),
        ({"damping": -0.1}, "damping=-0.1: expected a number >= 0"),
        ({"stop_distance": np.inf}, "stop_distance=inf: expected 1 finite number"),
    ],
)
def test_an_option_that_cannot_be_is_named(options: dict[str, Any], message: str) -> None:
    with pytest.raises(OptionError, match=re.escape(message)):
        factory("reach", "damped_least_squares", **options)
