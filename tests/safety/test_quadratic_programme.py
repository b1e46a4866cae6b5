import numpy as np
import pytest
import torch
from _inputs import normal
from _inputs.random_numbers import BATCHES
from _inputs.safety_bounds import closing, random_bounds, random_metric
from scipy.optimize import linprog
from torch import Tensor

from aicon_torch.safety import SafeAction, SafetyBounds, nearest_safe


def test_a_safe_wish_stays_as_it_is() -> None:
    within = random_bounds(50)
    nominal = torch.zeros(50, 4, dtype=torch.float64)
    action, force = nearest_safe(nominal, within, sweeps=3)
    assert (action == nominal).all()
    assert (force == 0).all()


@pytest.mark.parametrize("sweeps", [1, 3, 12])
def test_what_rest_keeps_is_kept_even_where_the_sweeps_have_not_converged(sweeps: int) -> None:
    within = random_bounds(500, rows=12)
    action, _ = nearest_safe(5 * normal(500, 4, seed=9), within, sweeps)
    slack = 1e-3 * within.high.amax(-1, keepdim=True) * within.slopes.norm(dim=-1)
    assert (closing(action, within) >= -slack).all()
    assert (action >= within.low).all()
    assert (action <= within.high).all()


def test_it_is_the_nearest_action_once_the_sweeps_have_converged() -> None:
    """None within the bounds is nearer to the nominal one: (v − a)·(w − a) ≤ 0 for every v."""
    within = random_bounds(40, rows=3)
    nominal = 2 * normal(40, 4, seed=9)
    action, _ = nearest_safe(nominal, within, sweeps=500)

    candidates = 2 * normal(2000, 40, 4, seed=10)
    allowed = (closing(candidates, within) >= 0).all(-1)
    allowed &= ((candidates >= within.low) & (candidates <= within.high)).all(-1)
    gain = ((candidates - action) * (nominal - action)).sum(-1)
    assert allowed.any(0).float().mean() > 0.5
    assert (gain[allowed] < 1e-3).all()


def test_the_force_is_what_the_bounds_add_to_the_wish() -> None:
    within = random_bounds(40, rows=3)
    nominal = 2 * normal(40, 4, seed=9)
    action, force = nearest_safe(nominal, within, sweeps=500)
    torch.testing.assert_close(nominal + force, action, rtol=1e-3, atol=1e-3)


def test_a_gap_that_closes_by_itself_moves_what_rests() -> None:
    slopes = torch.tensor([[1.0, 0.0]])
    limits = torch.ones(2)
    within = SafetyBounds(slopes, torch.tensor([0.3]), -limits, limits)
    action, _ = nearest_safe(torch.zeros(2), within, sweeps=3)
    torch.testing.assert_close(action, torch.tensor([0.3, 0.0]))


@pytest.mark.parametrize("sweeps", [3, 12])
def test_what_comes_nearer_is_dodged_whatever_is_wished_for(sweeps: int) -> None:
    """The sweeps need not converge: a nominal action across many rows never costs the retreat."""
    within = random_bounds(500, rows=12)
    within.bounds[:, 0] = 0.05 * within.slopes[:, 0].norm(dim=-1)
    at_rest, _ = nearest_safe(torch.zeros(500, 4, dtype=torch.float64), within, sweeps)
    hurried, _ = nearest_safe(5 * normal(500, 4, seed=9), within, sweeps)

    slack = 1e-3 * within.high.amax(-1, keepdim=True) * within.slopes.norm(dim=-1)
    as_well = closing(at_rest, within).clamp(max=0.0) - slack
    assert (closing(hurried, within) >= as_well).all()
    assert ((hurried - at_rest).norm(dim=-1) > 0.1).float().mean() > 0.2


def test_a_gap_that_no_action_changes_asks_for_nothing() -> None:
    limits = torch.ones(2)
    within = SafetyBounds(torch.zeros(1, 2), torch.tensor([0.3]), -limits, limits)
    nominal = torch.tensor([0.5, -0.5])
    action, _ = nearest_safe(nominal, within, sweeps=3)
    torch.testing.assert_close(action, nominal)


@pytest.mark.parametrize("batch", BATCHES)
def test_a_batch_is_as_many_singles(batch: tuple[int, ...]) -> None:
    within, nominal = random_bounds(*batch), normal(*batch, 4, seed=9)
    action, force = nearest_safe(nominal, within, sweeps=4)
    assert action.shape == force.shape == nominal.shape

    flat = SafetyBounds(*(value.reshape(-1, *value.shape[len(batch) :]) for value in within))
    for row, expected in enumerate(action.reshape(-1, 4)):
        single = SafetyBounds(*(value[row] for value in flat))
        found, _ = nearest_safe(nominal.reshape(-1, 4)[row], single, sweeps=4)
        torch.testing.assert_close(found, expected)


@pytest.mark.parametrize("sweeps", [4, None])
@pytest.mark.parametrize("batched", ["nominal", "slopes", "bounds", "high", "inverse", "coming"])
def test_the_leading_dimensions_of_one_are_those_of_all(batched: str, sweeps: int | None) -> None:
    bounds, coming = normal(6, 5, seed=1), normal(6, 5, seed=2).abs()
    within = random_bounds(6)._replace(bounds=0.3 * bounds)
    given = {**within._asdict(), "nominal": 5 * normal(6, 4, seed=9), "coming": coming}
    given["inverse"] = random_metric(6)

    def nearest(nominal: Tensor, inverse: Tensor, coming: Tensor, **bounds: Tensor) -> SafeAction:
        return nearest_safe(nominal, SafetyBounds(**bounds), sweeps, inverse, coming=coming)

    alone = {name: value if name == batched else value[0] for name, value in given.items()}
    whole = {name: value.expand_as(given[name]) for name, value in alone.items()}
    for found, expected in zip(nearest(**alone), nearest(**whole), strict=True):
        torch.testing.assert_close(found, expected)


def test_where_not_all_rows_can_be_kept_they_are_missed_alike() -> None:
    slopes, limits = torch.tensor([[1.0, 0.1], [-1.0, 0.1]]), torch.ones(2)
    within = SafetyBounds(slopes, torch.tensor([0.5, 0.5]), -limits, limits)
    action, _ = nearest_safe(torch.tensor([5.0, 0.0]), within, sweeps=2000)
    torch.testing.assert_close(
        closing(action, within), torch.tensor([-0.4, -0.4]), atol=0.01, rtol=0
    )


def test_what_stands_still_is_kept_where_what_comes_on_cannot_be_dodged() -> None:
    slopes, limits = torch.tensor([[1.0, 0.1], [-1.0, 0.0]]), torch.ones(2)
    within = SafetyBounds(slopes, torch.tensor([0.5, 0.0]), -limits, limits)
    action, _ = nearest_safe(torch.tensor([5.0, 0.0]), within, sweeps=12)
    coming, standing = closing(action, within).tolist()
    assert standing > -1e-3
    assert coming == pytest.approx(-0.4, abs=0.02)


def test_of_what_cannot_be_dodged_hardly_more_is_missed_than_has_to_be() -> None:
    """The least speed t by which some bound is missed is a linear programme: c·a + t ≥ b."""
    within = random_bounds(60, rows=8)
    within.bounds[:] = 0.5 + normal(60, 8, seed=3).abs()
    action, _ = nearest_safe(5 * normal(60, 4, seed=9), within, sweeps=12)
    missed = -closing(action, within).amin(-1)

    least = []
    for slopes, bounds, low, high in zip(*within, strict=True):
        box = [*zip(low.tolist(), high.tolist(), strict=True), (None, None)]
        rows = np.column_stack((-slopes.numpy(), -np.ones(8)))
        found = linprog([0.0] * 4 + [1.0], A_ub=rows, b_ub=-bounds.numpy(), bounds=box)
        least.append(max(0.0, found.fun))
    ratio = missed.clamp(min=0.0).numpy() / np.array(least).clip(min=1e-9)
    assert (np.array(least) > 0.1).mean() > 0.8
    assert np.median(ratio) < 1.15
    assert np.quantile(ratio, 0.9) < 1.5
