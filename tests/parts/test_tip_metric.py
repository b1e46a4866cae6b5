import torch
from _inputs import normal
from _inputs.arm import panda_chain, postures

from aicon_torch.parts.end_effector import EndEffector
from aicon_torch.parts.tip_metric import TipMetric
from aicon_torch.parts.tip_pose import TipPose

ARM = EndEffector(panda_chain(), TipPose("full"), damping=0.15)


def test_a_departure_counts_by_how_far_it_takes_the_tip_and_the_joints() -> None:
    q, departure = postures(5), normal(5, 7, seed=1)
    of_tip = (ARM.jacobian(q) @ departure.unsqueeze(-1)).squeeze(-1)
    weighed = (TipMetric(ARM)(q) @ departure.unsqueeze(-1)).squeeze(-1)
    expected = (of_tip * of_tip).sum(-1) + 0.15**2 * (departure * departure).sum(-1)
    torch.testing.assert_close((departure * weighed).sum(-1), expected)


def test_a_wish_is_the_damped_solution_of_the_same_metric() -> None:
    """M J⁺h = Jᵀh."""
    q, gradient = postures(5), normal(5, 12, seed=1)
    jacobian = ARM.jacobian(q)
    nominal = ARM.solve(jacobian, gradient).unsqueeze(-1)
    torch.testing.assert_close(TipMetric(ARM)(q) @ nominal, jacobian.mT @ gradient.unsqueeze(-1))
