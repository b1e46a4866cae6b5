"""The nearest action where some departures from the nominal action count more than others."""

import pytest
import torch
from _inputs import normal
from _inputs.random_numbers import BATCHES
from _inputs.safety_bounds import closing, random_bounds, random_metric

from aicon_torch.safety import SafetyBounds, nearest_safe


def test_where_all_components_count_alike_it_is_the_plain_projection() -> None:
    within, nominal = random_bounds(40), 2 * normal(40, 4, seed=9)
    identity = torch.eye(4, dtype=torch.float64).expand(40, 4, 4)
    for found, expected in zip(
        nearest_safe(nominal, within, 12, identity), nearest_safe(nominal, within, 12), strict=True
    ):
        torch.testing.assert_close(found, expected)


def test_it_is_the_nearest_action_in_the_metric_once_the_sweeps_have_converged() -> None:
    """(v − a)ᵀM(w − a) ≤ 0 for every v within the bounds."""
    within, square = random_bounds(40, rows=3), random_metric(40)
    nominal = 2 * normal(40, 4, seed=9)
    action, _ = nearest_safe(nominal, within, 3000, torch.linalg.inv(square))

    candidates = 2 * normal(2000, 40, 4, seed=10)
    allowed = (closing(candidates, within) >= 0).all(-1)
    allowed &= ((candidates >= within.low) & (candidates <= within.high)).all(-1)
    weighed = (square @ (nominal - action).unsqueeze(-1)).squeeze(-1)
    gain = ((candidates - action) * weighed).sum(-1)
    assert allowed.any(0).float().mean() > 0.5
    assert (gain[allowed] < 5e-3).all()


def test_the_force_is_what_the_bounds_add_as_the_metric_weighs_it() -> None:
    within, square = random_bounds(40, rows=3), random_metric(40)
    nominal = 2 * normal(40, 4, seed=9)
    action, force = nearest_safe(nominal, within, 3000, torch.linalg.inv(square))
    added = (square @ (action - nominal).unsqueeze(-1)).squeeze(-1)
    torch.testing.assert_close(added, force, rtol=1e-2, atol=1e-2)


def test_what_a_component_cannot_do_the_others_do() -> None:
    """One joint at its stop, and another that moves the same: only their sum counts."""
    row = torch.tensor([[1.0, 1.0]])
    square = row.mT @ row + 0.01 * torch.eye(2)
    within = SafetyBounds(torch.zeros(0, 2), torch.zeros(0), -torch.ones(2), torch.tensor([0.0, 1]))
    nominal = torch.tensor([0.3, 0.3])

    plain, _ = nearest_safe(nominal, within, 12)
    action, _ = nearest_safe(nominal, within, 12, torch.linalg.inv(square))
    torch.testing.assert_close(plain, torch.tensor([0.0, 0.3]))
    torch.testing.assert_close(action, torch.tensor([0.0, 0.6]), rtol=0, atol=0.01)


@pytest.mark.parametrize("sweeps", [1, 3, 12])
def test_what_rest_keeps_is_kept_even_where_the_sweeps_have_not_converged(sweeps: int) -> None:
    within = random_bounds(500, rows=12)
    inverse = torch.linalg.inv(random_metric(500))
    action, _ = nearest_safe(5 * normal(500, 4, seed=9), within, sweeps, inverse)
    slack = 1e-3 * within.high.amax(-1, keepdim=True) * within.slopes.norm(dim=-1)
    assert (closing(action, within) >= -slack).all()
    assert (action >= within.low).all()
    assert (action <= within.high).all()


def test_a_gap_that_no_action_changes_asks_for_nothing() -> None:
    limits, nominal = torch.ones(2), torch.tensor([0.5, -0.5])
    within = SafetyBounds(torch.zeros(1, 2), torch.tensor([0.3]), -limits, limits)
    action, _ = nearest_safe(nominal, within, 3, torch.eye(2))
    torch.testing.assert_close(action, nominal)


@pytest.mark.parametrize("batch", BATCHES)
def test_a_batch_is_as_many_singles(batch: tuple[int, ...]) -> None:
    within, nominal = random_bounds(*batch), normal(*batch, 4, seed=9)
    inverse = torch.linalg.inv(random_metric(*batch))
    action, _ = nearest_safe(nominal, within, 4, inverse)

    flat = SafetyBounds(*(value.reshape(-1, *value.shape[len(batch) :]) for value in within))
    rows = zip(
        action.reshape(-1, 4), nominal.reshape(-1, 4), inverse.reshape(-1, 4, 4), strict=True
    )
    for row, (expected, single_wish, single_inverse) in enumerate(rows):
        single = SafetyBounds(*(value[row] for value in flat))
        found, _ = nearest_safe(single_wish, single, 4, single_inverse)
        torch.testing.assert_close(found, expected)
