"""Hysteresis: who holds a rank keeps it up to a margin."""

import math

import pytest
import torch
from _inputs import ranks, resolve, resolved, unweighted, weighted
from torch import Tensor

IN_THE_PLANE = torch.tensor([[1.0, 0.0], [0.6, 0.8]], dtype=torch.float64)
IN_SPACE = torch.eye(3, dtype=torch.float64)


def with_lengths(*lengths: float, directions: Tensor) -> Tensor:
    return directions * torch.tensor(lengths, dtype=torch.float64).unsqueeze(-1)


def test_what_has_vanished_holds_no_rank() -> None:
    stack = torch.zeros(2, 4, 3, dtype=torch.float64)
    stack[0, 2] = torch.tensor([0.0, 1.0, 2.0])

    assert ranks(unweighted(), stack).tolist() == [[2, -1, -1], [-1, -1, -1]]
    assert not resolved(unweighted(), stack)[1].any()


def test_a_rank_that_nobody_held_favours_nobody() -> None:
    """A gradient that appears is not second for having been zero before."""
    stack = torch.zeros(3, 3, dtype=torch.float64)
    stack[2, 2] = 3.0
    _, memory = resolve(unweighted(), stack)

    stack[0, 0], stack[1, 1] = 1.0, 1.05
    for order in ([0, 1, 2], [1, 0, 2]):
        _, after = resolve(unweighted(), stack[order], memory)
        assert after["rank"][:2].tolist() == [2, order.index(1)]


@pytest.mark.parametrize(
    ("factor", "takes_over"), [(1.05, False), (1.0999, False), (1.1001, True), (1.15, True)]
)
def test_a_competitor_takes_the_lead_only_beyond_the_margin(
    factor: float, takes_over: bool
) -> None:
    rule = unweighted(margin=0.1)
    _, memory = resolve(rule, with_lengths(1.0, 0.9, directions=IN_THE_PLANE))
    assert memory["rank"].tolist() == [0, 1]

    stronger = with_lengths(1.0, factor, directions=IN_THE_PLANE)
    _, after = resolve(rule, stronger, memory)
    assert (after["rank"][0] == 1) == takes_over
    assert ranks(unweighted(margin=0.0), stronger)[0] == 1


@pytest.mark.parametrize(("factor", "takes_over"), [(1.05, False), (1.15, True)])
def test_the_margin_holds_at_every_rank(factor: float, takes_over: bool) -> None:
    """The second rank is held by the magnitude that is left after projection."""
    _, memory = resolve(unweighted(), with_lengths(5.0, 1.0, 0.9, directions=IN_SPACE))
    assert memory["rank"].tolist() == [0, 1, 2]

    stronger = with_lengths(5.0, 1.0, factor, directions=IN_SPACE)
    _, after = resolve(unweighted(), stronger, memory)
    assert after["rank"].tolist() == ([0, 2, 1] if takes_over else [0, 1, 2])


@pytest.mark.parametrize(("ratio_of_weights", "takes_over"), [(1.05, False), (1.15, True)])
def test_the_margin_acts_on_the_normalised_magnitudes(
    ratio_of_weights: float, takes_over: bool
) -> None:
    """With a softmax, a competitor that is 15 % longer is only a few percent stronger."""
    rule = weighted(temperature=0.8)
    _, memory = resolve(rule, with_lengths(0.4, 0.3, directions=IN_THE_PLANE))

    length = 0.4 + 0.8 * math.log(ratio_of_weights)
    _, after = resolve(rule, with_lengths(0.4, length, directions=IN_THE_PLANE), memory)
    assert (after["rank"][0] == 1) == takes_over


def test_hysteresis_is_of_each_row() -> None:
    stack = torch.tensor([[1.0, 0.0], [0.63, 0.84]], dtype=torch.float64).expand(2, 2, 2)
    held = torch.tensor([[0, 1], [1, 0]])

    _, memory = resolve(unweighted(), stack, {"rank": held})
    assert torch.equal(memory["rank"], held)
