import pytest
import torch

from aicon_torch import by_worth


def test_what_a_motion_is_worth_is_what_it_would_lower_the_cost_by() -> None:
    for distance, expected in ((0.02, 0.0002), (0.2, 0.2 * 0.05 - 0.05**2 / 2)):
        weight = torch.tensor([0.5], requires_grad=True)
        place = torch.tensor([distance, 0.0])
        moved = place + by_worth(weight, place, step=0.05)
        assert torch.equal(moved, place)

        (slope,) = torch.autograd.grad(moved.square().sum() / 2, weight)
        assert float(slope) == pytest.approx(-expected)
