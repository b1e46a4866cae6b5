"""How much room a target of reaching leaves."""

import numpy as np
import pytest
import torch

pytest.importorskip("mujoco")

from aicon_baselines.tasks.reach import TASK
from aicon_torch.parts import Robot, TipPose
from reach_room import MARGIN, SOLVED, solutions


def test_solutions_are_at_the_target_and_within_the_stops() -> None:
    options = TASK.policy_options("ur5_pose_home")
    robot = Robot.from_urdf(options["robot"], tip=options["tip"], collisions=False)
    pose = TipPose("full", lever=1.0)
    posture = torch.tensor([0.3, -1.2, 1.0, -1.0, -1.3, 0.2], dtype=torch.float64)
    target = pose.of_frame(robot.chain(posture))

    found = torch.from_numpy(np.stack(solutions(robot, pose, target, starts=10)))
    low, high = robot.chain.low, robot.chain.high
    assert len(found) > 1 and (found - found[0]).abs().max() > 0.1  # the arm has several
    assert (pose.of_frame(robot.chain(found)) - target).norm(dim=-1).max() < SOLVED
    assert ((found - low).min() >= MARGIN - 1e-9) and ((high - found).min() >= MARGIN - 1e-9)
