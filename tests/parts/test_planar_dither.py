import torch
from _inputs.arm import panda, postures

from aicon_torch.parts.planar_dither import PlanarDither


def test_the_tip_moves_along_the_axes_at_its_speed_and_nothing_else_does() -> None:
    arm, q = panda(damping=1e-4), postures(5)
    motions = arm.jacobian(q) @ PlanarDither(arm, speed=0.4)(q)
    expected = 0.4 * torch.eye(6, dtype=q.dtype)[:, :2]
    torch.testing.assert_close(motions, expected.expand(5, 6, 2), atol=1e-5, rtol=0)


def test_the_joints_move_no_further_than_that_takes() -> None:
    """Nothing is in their nullspace: D = JᵀY for some Y."""
    arm, q = panda(), postures(5)
    motions, jacobian = PlanarDither(arm, speed=0.4)(q), arm.jacobian(q)
    along = jacobian.mT @ torch.linalg.solve(jacobian @ jacobian.mT, jacobian @ motions)
    torch.testing.assert_close(along, motions)
