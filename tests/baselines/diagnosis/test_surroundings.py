"""What lies around the robot when an episode ends is where the environment says."""

import numpy as np
import pytest

from aicon_baselines.diagnosis.surroundings import Surroundings, surroundings
from aicon_baselines.tasks import load


def around(name: str, condition: str) -> Surroundings:
    """The surroundings at the beginning of an episode."""
    task = load(name)
    env = task.make_env(1, condition, 10)
    observation, info = env.reset(**task.reset_arguments([task.episode(1000)]))
    found = surroundings(name, env, observation, info)
    env.close()
    return found


def test_navigation_has_walls_and_a_target() -> None:
    found = around("nav2d", "range")
    assert found.walls and all(wall.shape[1:] == (2,) for wall in found.walls)
    assert found.target is not None and found.target.shape == (2,)


@pytest.mark.parametrize(
    ("task", "condition", "needed"),
    [("pusht", "deterministic", "pymunk"), ("arm_push", "true_pose", "mujoco")],
)
def test_who_pushes_has_an_object_and_its_goal(task: str, condition: str, needed: str) -> None:
    pytest.importorskip(needed)
    found = around(task, condition)
    assert found.thing is not None and found.goal is not None

    # The same outline at two poses.
    lengths = [
        np.linalg.norm(np.diff(outline, axis=0), axis=1) for outline in (found.thing, found.goal)
    ]
    np.testing.assert_allclose(*lengths, rtol=1e-12)
    assert not np.allclose(found.thing, found.goal)


def test_an_arm_that_reaches_has_a_target() -> None:
    pytest.importorskip("trimesh")
    found = around("reach", "panda_pose_home")
    assert found.target is not None and found.target.shape == (2,)
