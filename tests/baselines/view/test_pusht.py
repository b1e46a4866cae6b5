"""Hands on the world of pushT."""

from collections.abc import Iterator

import numpy as np
import pytest

pytest.importorskip("viser", reason="the live view needs the extra [view]")
pytest.importorskip("pymunk", reason="pushT needs the extra [pusht]")

from aicon_baselines.view import make_scene, open_episode
from aicon_baselines.view.scene import Scene
from aicon_baselines.view.server import serve


@pytest.fixture(scope="module")
def scene() -> Iterator[Scene]:
    """The scene of an episode that has just started."""
    server = serve("127.0.0.1", 0)
    scene = make_scene(server, open_episode("pusht", seed=1004))
    scene.start()
    yield scene
    server.stop()


def test_a_kick_moves_the_object_and_nothing_else(scene: Scene) -> None:
    before = scene.episode.info
    scene.kick()
    after = scene.episode.info
    assert np.linalg.norm(after["block_pose"] - before["block_pose"]) > 1e-3
    np.testing.assert_array_equal(after["goal_pose"], before["goal_pose"])
    np.testing.assert_array_equal(after["pos_agent"], before["pos_agent"])


def test_the_policy_sees_a_goal_that_is_moved(scene: Scene) -> None:
    goal = scene.handles()["goal"]
    cost = scene.episode.trace.costs["push"].clone()
    elsewhere = goal.where() + np.array([1.2, 0.0, 0.0])
    goal.move(elsewhere)
    np.testing.assert_allclose(goal.where(), elsewhere)
    assert not np.isclose(float(scene.episode.trace.costs["push"]), float(cost))


@pytest.mark.parametrize("name", ["nullspace projection", "sum", "steepest path"])
def test_every_side_has_an_arrow_under_each_resolution(scene: Scene, name: str) -> None:
    scene.episode.resolve_by(name)
    scene.draw()
    assert len(scene.arrows()) >= 8
    assert set(scene.strengths()) == {"strongest to touch", "to leave"}
