"""What lies around the robot is where the environment says, on paper as on a page."""

import numpy as np
import pytest
from matplotlib.figure import Figure

from aicon_baselines.palette import OBSTACLE
from aicon_baselines.tasks import load
from aicon_baselines.worlds import Shape, believed, surroundings
from aicon_baselines.worlds.paper import Paper


def around(name: str, condition: str) -> dict[str, Shape]:
    """The surroundings at the beginning of an episode."""
    task = load(name)
    env = task.make_env(1, condition, 10)
    _, info = env.reset(**task.reset_arguments([task.episode(1000)]))
    found = surroundings(name, env, {key: values[0] for key, values in info.items()})
    env.close()
    return found


def test_navigation_has_walls_and_a_target() -> None:
    found = around("nav2d", "range")
    assert {"target", "wall.0"} <= found.keys()
    assert all(shape.points.shape[1:] == (2,) for shape in found.values())


@pytest.mark.parametrize(
    ("task", "condition", "needed"),
    [("pusht", "deterministic", "pymunk"), ("arm_push", "true_pose", "mujoco")],
)
def test_who_pushes_has_an_object_and_its_goal(task: str, condition: str, needed: str) -> None:
    pytest.importorskip(needed)
    found = around(task, condition)

    # The same outline at two poses.
    outlines = [found[name].points for name in ("object", "goal")]
    lengths = [np.linalg.norm(np.diff(outline, axis=0), axis=1) for outline in outlines]
    np.testing.assert_allclose(*lengths, rtol=1e-12)
    assert not np.allclose(*outlines)


def test_an_arm_that_reaches_has_a_target() -> None:
    pytest.importorskip("trimesh")
    assert set(around("reach", "panda_pose_home")) == {"target"}


def test_a_belief_reaches_two_standard_deviations() -> None:
    points = believed((1.0, 2.0), np.diag([0.25, 1.0]), 0, OBSTACLE).points
    np.testing.assert_allclose(np.abs(points - (1.0, 2.0)).max(axis=0), (1.0, 2.0), rtol=1e-2)


def test_a_shape_that_is_drawn_again_moves() -> None:
    axes = Figure().subplots()
    paper, square = Paper(axes), np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)])
    for shift in (0.0, 2.0):
        paper.draw({"wall.0": Shape(square + shift, 0, OBSTACLE)})

    (patch,) = axes.patches
    np.testing.assert_array_equal(patch.get_xy()[:3], square + 2.0)
