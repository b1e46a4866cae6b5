import pytest
import torch

from aicon_torch.errors import OptionError
from aicon_torch.parts.hinge import SquaredHinge


def test_it_costs_nothing_beyond_the_margin_and_the_weight_where_nothing_is_left():
    cost = SquaredHinge(margin=0.1, weight=0.5)
    for distance, expected in ((0.2, 0.0), (0.1, 0.0), (0.05, 0.125), (0.0, 0.5), (-0.1, 2.0)):
        assert float(cost(torch.tensor([distance]))) == pytest.approx(expected)


def test_a_margin_of_nothing_is_refused() -> None:
    with pytest.raises(OptionError, match="margin=0.0: expected a positive number"):
        SquaredHinge(margin=0.0, weight=1.0)


def test_distances_add_up():
    cost = SquaredHinge(margin=0.1, weight=0.5)
    distances = torch.tensor([[0.0, 0.05, 3.0], [1.0, 2.0, 3.0]])
    torch.testing.assert_close(cost(distances), torch.tensor([0.625, 0.0]))


def test_it_grows_smoothly_out_of_nothing():
    distance = torch.tensor([0.1], dtype=torch.float64, requires_grad=True)
    (slope,) = torch.autograd.grad(SquaredHinge(0.1, 0.5)(distance), distance)
    assert slope == 0
