"""Hands on the worlds of arms, and gradients of joints as arrows at the tip."""

from collections.abc import Iterator

import numpy as np
import pytest

pytest.importorskip("viser", reason="the live view needs the extra [view]")
pytest.importorskip("mujoco", reason="the arms need MuJoCo")

import mujoco

from aicon_baselines.view import make_scene, open_episode
from aicon_baselines.view.episode import ANYWHERE
from aicon_baselines.view.server import serve
from aicon_baselines.view.space import MuJoCoScene

CONDITIONS = {"arm_push": "true_pose", "reach": "panda_pose_home_ball"}
POLICIES = {"arm_push": "aicon,law.iterations=2", "reach": "aicon"}
"""A lean one, for what holds however many gradients a step has."""


@pytest.fixture(scope="module", params=["arm_push", pytest.param("reach", marks=pytest.mark.slow)])
def scene(request: pytest.FixtureRequest) -> Iterator[MuJoCoScene]:
    """The scene of an episode that has just started."""
    server = serve("127.0.0.1", 0)
    task = request.param
    episode = open_episode(task, POLICIES[task], CONDITIONS[task], seed=1000)
    scene = make_scene(server, episode)
    assert isinstance(scene, MuJoCoScene)
    scene.start()
    yield scene
    server.stop()


def test_what_is_dragged_is_where_it_was_let_go_and_the_episode_goes_on(
    scene: MuJoCoScene,
) -> None:
    for name, handle in scene.handles().items():
        steps = scene.episode.steps
        place = handle.where() + np.array([0.03, 0.02, 0.0])
        handle.move(place)
        np.testing.assert_allclose(handle.where()[:2], place[:2], atol=1e-6, err_msg=name)

        scene.episode.step()
        scene.draw()
        np.testing.assert_allclose(handle.where()[:2], place[:2], atol=2e-3, err_msg=name)
        assert scene.episode.steps == steps + 1


def test_the_policy_sees_a_target_that_is_moved(scene: MuJoCoScene) -> None:
    (goal, *_) = scene.episode.policy.model.goals
    handle = scene.handles()["target"]
    before = float(scene.episode.trace.costs[goal])
    handle.move(handle.where() + np.array([0.05, -0.05, 0.0]))
    scene.episode.step()
    assert abs(float(scene.episode.trace.costs[goal]) - before) > 1e-3


def test_an_arrow_of_the_joints_is_where_the_tip_would_go(scene: MuJoCoScene) -> None:
    (actuator,) = scene.episode.policy.model.actuators
    gradient = np.random.default_rng(0).normal(size=7)
    arrow = scene.way(actuator, -gradient)

    # Descending a little moves the tip by as much, to first order.
    model, data, size = scene.model, mujoco.MjData(scene.model), 1e-6
    data.qpos[:] = scene.data.qpos
    mujoco.mj_kinematics(model, data)
    before = data.site("tip").xpos.copy()
    data.qpos[:7] -= size * gradient
    mujoco.mj_kinematics(model, data)
    moved = (data.site("tip").xpos - before) / size
    np.testing.assert_allclose(moved, arrow, rtol=0.02, atol=2e-3)  # one physics step apart


@pytest.mark.parametrize(
    "name",
    [
        pytest.param("sum", marks=pytest.mark.slow),
        pytest.param("steepest path", marks=pytest.mark.slow),
        "nullspace projection",
    ],
)
def test_every_quantity_can_be_looked_at_under_each_resolution(
    scene: MuJoCoScene, name: str
) -> None:
    scene.episode.resolve_by(name)
    for quantity in scene.episode.trace.quantities:
        scene.episode.look_at(quantity)
        scene.draw()
        assert len(scene.arrows()) == len(scene.episode.meeting.paths)
    scene.episode.look_at(ANYWHERE)


@pytest.mark.parametrize("scene", ["arm_push"], indirect=True)
def test_a_kick_moves_the_object(scene: MuJoCoScene) -> None:
    before = scene.episode.info["object_pose"][0].copy()
    scene.kick()
    for _ in range(5):
        scene.episode.step()
    assert np.linalg.norm(scene.episode.info["object_pose"][0] - before) > 0.01
