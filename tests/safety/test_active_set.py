"""The nearest action that keeps the bounds, exactly."""

import pytest
import torch
from _inputs import normal
from _inputs.random_numbers import BATCHES
from _inputs.safety_bounds import closing, random_bounds, random_metric
from torch import Tensor

from aicon_torch.differentiation import through_time
from aicon_torch.errors import OptionError
from aicon_torch.safety import SafetyBounds, nearest_safe
from aicon_torch.safety.active_set import exactly


@pytest.mark.parametrize("rows", [1, 3, 40])
def test_every_bound_is_kept_and_no_allowed_action_is_nearer(rows: int) -> None:
    """(v − a)ᵀM(w − a) ≤ 0 for every v within the bounds."""
    within, square = random_bounds(40, rows=rows), random_metric(40)
    nominal = 2 * normal(40, 4, seed=9)
    action, _ = nearest_safe(nominal, within, None, torch.linalg.inv(square))
    assert (closing(action, within) >= -1e-9).all()
    assert ((action >= within.low) & (action <= within.high)).all()

    # Random actions, drawn toward rest until they are allowed as well.
    candidates = 2 * normal(500, 40, 4, seed=10) * torch.rand(500, 40, 1, dtype=torch.float64)
    allowed = (closing(candidates, within) >= 0).all(-1)
    allowed &= ((candidates >= within.low) & (candidates <= within.high)).all(-1)
    weighed = (square @ (nominal - action).unsqueeze(-1)).squeeze(-1)
    gain = ((candidates - action) * weighed).sum(-1)
    assert allowed.any()
    assert (gain[allowed] < 1e-9).all()


def test_it_is_what_sweeps_come_to() -> None:
    within, nominal = random_bounds(40, rows=6), 2 * normal(40, 4, seed=9)
    inverse = torch.linalg.inv(random_metric(40))
    exactly = nearest_safe(nominal, within, None, inverse)
    swept = nearest_safe(nominal, within, 3000, inverse)
    torch.testing.assert_close(exactly.action, swept.action, rtol=0, atol=1e-3)


def test_the_force_is_what_the_bounds_add_as_the_metric_weighs_it() -> None:
    within, square = random_bounds(40, rows=12), random_metric(40)
    nominal = 2 * normal(40, 4, seed=9)
    action, force = nearest_safe(nominal, within, None, torch.linalg.inv(square))
    added = (square @ (action - nominal).unsqueeze(-1)).squeeze(-1)
    torch.testing.assert_close(added, force)


def test_rows_that_are_almost_one_are_kept_like_one() -> None:
    one, nominal = random_bounds(40, rows=3), 2 * normal(40, 4, seed=9)
    more = 1e-9 * normal(40, 20, 3, 4, seed=11)
    slopes = (one.slopes.unsqueeze(-3) + more).flatten(-3, -2)
    many = SafetyBounds(slopes, one.bounds.repeat(1, 20), one.low, one.high)
    expected = nearest_safe(nominal, one, None).action
    torch.testing.assert_close(nearest_safe(nominal, many, None).action, expected)


def test_between_two_walls_it_goes_along_them() -> None:
    slopes = torch.tensor([[1.0, 0.0, 1e-7], [-1.0, 1e-7, 0.0]])
    within = SafetyBounds(slopes, torch.zeros(2), -torch.ones(3), torch.ones(3))
    action, _ = nearest_safe(torch.tensor([0.9, 0.4, -0.3]), within, None)
    torch.testing.assert_close(action, torch.tensor([0.0, 0.4, -0.3]), rtol=0, atol=1e-4)


def test_where_no_action_keeps_all_bounds_it_misses_as_little_of_each() -> None:
    slopes, bounds = torch.tensor([[1.0, 0.0], [-1.0, 0.0]]), torch.tensor([0.2, 0.2])
    within = SafetyBounds(slopes, bounds, -torch.ones(2), torch.ones(2))
    action, _ = nearest_safe(torch.tensor([0.5, 0.5]), within, None)
    torch.testing.assert_close(action[0], torch.tensor(0.0), rtol=0, atol=1e-3)


def test_bounds_that_nearly_oppose_each_other_in_a_metric_leave_the_rest_free() -> None:
    slopes = torch.tensor([[1.0, 0.0, 0.0], [-1.0, 2.3e-5, 0.0]], dtype=torch.float64)
    nominal = torch.tensor([-0.9, -0.6, 0.7], dtype=torch.float64)
    box, inverse = torch.ones_like(nominal), torch.diag(nominal.new_tensor([1.0, 0.01, 1.0]))
    within = SafetyBounds(slopes, torch.zeros(2, dtype=torch.float64), -box, box)
    action, _ = nearest_safe(nominal, within, None, inverse)
    torch.testing.assert_close(action, torch.tensor([0.0, 0.0, 0.7]).double(), rtol=0, atol=1e-4)


@pytest.mark.parametrize("batch", BATCHES)
def test_a_batch_is_as_many_singles(batch: tuple[int, ...]) -> None:
    within, nominal = random_bounds(*batch), normal(*batch, 4, seed=9)
    inverse = torch.linalg.inv(random_metric(*batch))
    action, _ = nearest_safe(nominal, within, None, inverse)

    flat = SafetyBounds(*(value.reshape(-1, *value.shape[len(batch) :]) for value in within))
    rows = zip(nominal.reshape(-1, 4), inverse.reshape(-1, 4, 4), strict=True)
    for row, (single_nominal, single_inverse) in enumerate(rows):
        single = SafetyBounds(*(value[row] for value in flat))
        found, _ = nearest_safe(single_nominal, single, None, single_inverse)
        torch.testing.assert_close(action.reshape(-1, 4)[row], found)


def test_a_bound_that_is_no_number_bounds_nothing() -> None:
    slopes = torch.tensor([[1.0, 0.0], [0.0, 1.0]])
    within = SafetyBounds(slopes, torch.tensor([torch.nan, 0.0]), -torch.ones(2), torch.ones(2))
    identity = torch.eye(2)
    rows = (within.slopes, within.bounds, identity)
    found = exactly(torch.tensor([-0.5, -0.5]), *rows)
    torch.testing.assert_close(found[:2], torch.tensor([-0.5, 0.0]))


@pytest.mark.parametrize("inverse", [torch.full((2, 2), torch.nan), torch.ones(2, 2)])
def test_in_no_metric_it_stays_what_was_asked_for(inverse: Tensor) -> None:
    nominal = torch.tensor([-0.5, -0.5])
    found = exactly(nominal, torch.eye(2), torch.zeros(2), inverse)
    torch.testing.assert_close(found[:2], nominal)


def test_nothing_is_learned_through_it() -> None:
    within, nominal = random_bounds(), normal(4)
    with (
        through_time(),
        pytest.raises(OptionError, match="dampers.sweeps=None: gradients do not go through"),
    ):
        nearest_safe(nominal, within, None)
