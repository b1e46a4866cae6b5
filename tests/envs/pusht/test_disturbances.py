"""Kicks of the object."""

import numpy as np
import pytest
import shapely
from _pusht_env import APART
from shapely.geometry import Polygon

from aicon_envs.pusht import OBJECTS, PushTEnv
from aicon_envs.pusht.geometry import place
from aicon_envs.pusht.simulation import PUSHER_RADIUS, WALL_HIGH, WALL_LOW


@pytest.mark.parametrize("object", OBJECTS)
def test_kicks_come_on_time_within_their_size_and_leave_the_object_free(object: str) -> None:
    env = PushTEnv(object=object, kick_interval=4, goal_pose=(400.0, 400.0, 0.0))
    stay = np.array(APART[:2], np.float32)
    center = np.array([env.object.center_of_gravity])

    shifts = []
    for seed in range(30):
        _, info = env.reset(seed=seed, options={"reset_to_state": APART})

        for step in range(1, 14):
            before = info["block_pose"]
            _, _, _, _, info = env.step(stay)
            pose = info["block_pose"]

            shift = np.linalg.norm(place(center, tuple(pose)) - place(center, tuple(before)))
            if step % 4 == 1 and step > 1:
                assert shift <= 30.0 + 1e-9 and abs(pose[2] - before[2]) <= 0.5 + 1e-9
                shifts.append(shift)
            else:
                assert shift < 1e-9

            outline = Polygon(place(env.object.outline, tuple(pose)))
            assert outline.distance(shapely.Point(info["pos_agent"])) >= PUSHER_RADIUS
            assert min(outline.bounds) >= WALL_LOW and max(outline.bounds) <= WALL_HIGH

    assert np.mean(shifts) > 11.0
