"""Random and jumping goals, and how far the object is from one."""

import numpy as np
import pytest
from _pusht_env import APART, GOAL
from hypothesis import given
from hypothesis import strategies as st
from shapely.geometry import Polygon

from aicon_envs.pusht import OBJECTS, PushTEnv
from aicon_envs.pusht.geometry import place
from aicon_envs.pusht.simulation import WALL_HIGH, WALL_LOW


@pytest.mark.parametrize("object", OBJECTS)
def test_random_goals_fit_between_the_walls(object: str) -> None:
    env = PushTEnv(object=object, goal_pose="random")
    goals = np.array([env.reset(seed=seed)[1]["goal_pose"] for seed in range(200)])
    corners = np.array([place(env.object.keypoints, tuple(goal)) for goal in goals])

    # They fit, and use all of the room and all angles.
    assert corners.min() >= WALL_LOW and corners.max() <= WALL_HIGH
    assert corners.min() < WALL_LOW + 10.0 and corners.max() > WALL_HIGH - 10.0
    assert goals[:, 2].min() < -3.0 and goals[:, 2].max() > 3.0


def test_goal_jumps_put_success_off_until_the_last() -> None:
    env = PushTEnv(goal_jumps=2)
    stay = np.array(APART[:2], np.float32)

    for seed in range(5):
        _, info = env.reset(seed=seed, options={"reset_to_state": [*APART[:2], *GOAL]})
        goals, jump_steps = [tuple(info["goal_pose"])], [0]

        for step in range(245):
            before = info["goal_pose"]
            _, reward, terminated, _, info = env.step(stay)
            assert not terminated

            if (info["goal_pose"] != before).any():
                goals.append(tuple(info["goal_pose"]))
                jump_steps.append(step)
            assert (reward == 1.0) == (len(goals) == 1)

        assert len(set(goals)) == 3
        assert all(40 <= interval <= 120 for interval in np.diff(jump_steps))


@given(
    dx=st.floats(-150.0, 150.0),
    dy=st.floats(-150.0, 150.0),
    angle=st.floats(-4.0, 4.0),
    name=st.sampled_from([*OBJECTS]),
)
def test_coverage_is_the_share_of_the_area_in_the_goal(
    dx: float, dy: float, angle: float, name: str
) -> None:
    env = PushTEnv(object=name)
    state = [*APART[:2], 256.0 + dx, 256.0 + dy, angle]
    _, info = env.reset(options={"reset_to_state": state})

    block = Polygon(place(env.object.outline, tuple(info["block_pose"])))
    goal = Polygon(place(env.object.outline, tuple(info["goal_pose"])))
    share = block.intersection(goal).area / goal.area
    assert info["coverage"] == pytest.approx(share, abs=1e-9)


@pytest.mark.parametrize("name", OBJECTS)
def test_pose_error_weighs_a_turn_by_the_radius_of_gyration(name: str) -> None:
    pushed = OBJECTS[name]
    env = PushTEnv(object=name, goal_pose=(256.0, 256.0, 0.0))

    _, info = env.reset(options={"reset_to_state": [*APART[:2], 259.0, 252.0, 0.0]})
    assert info["pose_error"] == pytest.approx(5.0)

    # Turned by 2 rad about the centre of gravity.
    center = np.array([pushed.center_of_gravity])
    shift = (center - place(center, (0.0, 0.0, 2.0)))[0]
    _, info = env.reset(options={"reset_to_state": [*APART[:2], *(shift + 256.0), 2.0]})
    assert info["pose_error"] == pytest.approx(2.0 * pushed.radius_of_gyration)
