"""Rules of multi-task learning as resolutions: what holds for all, and what each promises."""

from importlib.util import find_spec
from itertools import product
from typing import Any

import numpy as np
import pytest
import torch
from _inputs import drifting, lean
from _inputs.gradients import DEGENERATE, STACKS
from _inputs.random_numbers import normal
from _inputs.rules import resolve, resolved
from torch import Tensor

from aicon_baselines.evaluation import ComparisonError
from aicon_baselines.resolutions import CAGrad, PCGrad, UPGrad
from aicon_torch import OptionError

AGGREGATIONS = [
    pytest.param(
        rule,
        marks=pytest.mark.skipif(
            any(find_spec(module) is None for module in rule.modules), reason="needs [peers]"
        ),
        id=rule.__name__,
    )
    for rule in (PCGrad, UPGrad, CAGrad)
]
FREE = torch.tensor([[1.0, 0.2, 0.0], [0.3, 1.0, 0.1], [0.5, 0.4, 0.9]], dtype=torch.float64)
"""Gradients of which no two are in conflict."""


@pytest.mark.parametrize("rule", AGGREGATIONS)
@pytest.mark.parametrize("name", STACKS)
def test_every_stack_has_a_finite_resolution(rule: Any, name: str) -> None:
    gradients = STACKS[name]
    total, memory = resolve(rule(), gradients)

    assert total.shape == gradients[..., 0, :].shape and total.dtype == gradients.dtype
    assert total.isfinite().all() and memory == {}


@pytest.mark.parametrize("rule", AGGREGATIONS)
def test_nothing_is_resolved_to_nothing_and_nan_stays_nan(rule: Any) -> None:
    gradients = torch.stack([torch.zeros(3, 2), torch.full((3, 2), torch.nan), torch.ones(3, 2)])
    nothing, unknown, agreed = resolved(rule(), gradients)
    assert (nothing == 0).all() and unknown.isnan().all() and (agreed > 0).all()


@pytest.mark.parametrize("rule", AGGREGATIONS)
def test_a_batch_is_resolved_as_its_rows_are(rule: Any) -> None:
    gradients = normal(2, 3, 4, 3, seed=5)
    batch = resolved(rule(), gradients)
    for i, j in product(range(2), range(3)):
        assert torch.equal(batch[i, j], resolved(rule(), gradients[i, j]))


@pytest.mark.parametrize("rule", AGGREGATIONS)
def test_the_resolution_has_the_scale_of_the_gradients(rule: Any) -> None:
    gradients = normal(5, 4, 3, seed=6)
    total = resolved(rule(), gradients)
    for scale in (1e-12, 1e9):
        torch.testing.assert_close(resolved(rule(), scale * gradients), scale * total)


@pytest.mark.parametrize("rule", AGGREGATIONS[:2])
def test_without_a_conflict_it_is_the_sum(rule: Any) -> None:
    torch.testing.assert_close(resolved(rule(), FREE), FREE.sum(-2), rtol=1e-3, atol=0.0)


@pytest.mark.parametrize("rule", AGGREGATIONS[:1])
def test_two_that_conflict_lose_their_components_against_each_other(rule: Any) -> None:
    first, second = normal(2, 3, seed=7)
    second = second - 2.0 * first
    product_of_both = first @ second
    assert product_of_both < 0

    expected = first - product_of_both / second.square().sum() * second
    expected = expected + second - product_of_both / first.square().sum() * first
    torch.testing.assert_close(resolved(rule(), torch.stack([first, second])), expected)


@pytest.mark.parametrize("rule", AGGREGATIONS[:1])
def test_it_leaves_the_random_numbers_of_others_alone(rule: Any) -> None:
    state = torch.get_rng_state()
    resolved(rule(), normal(5, 3, seed=8))
    assert torch.equal(torch.get_rng_state(), state)


@pytest.mark.parametrize("rule", AGGREGATIONS[1:2])
def test_unconflicting_projections_harm_no_goal(rule: Any) -> None:
    gradients = normal(50, 3, 4, seed=9)
    gains = (gradients @ resolved(rule(), gradients).unsqueeze(-1)).squeeze(-1)
    assert (gains >= -0.01).all()


@pytest.mark.parametrize("rule", AGGREGATIONS[2:])
def test_the_conflict_averse_gradient_serves_its_worst_goal_best(rule: Any) -> None:
    """No other point of the ball's border, tried in small steps, serves that goal better."""
    angles = torch.linspace(0.0, 2.0 * np.pi, 2000, dtype=torch.float64)
    circle = torch.stack([angles.cos(), angles.sin()], dim=-1)

    for gradients in normal(20, 3, 2, seed=10):
        mean = gradients.mean(0)
        ball = mean + 0.5 * mean.norm() * circle
        best = (ball @ gradients.T).amin(-1).max()
        found = (gradients @ resolved(rule(c=0.5), gradients) / 3).amin()
        assert found >= best - 1e-3


@pytest.mark.parametrize("rule", AGGREGATIONS[2:])
def test_it_is_that_of_torchjd(rule: Any) -> None:
    pytest.importorskip("cvxpy")
    aggregation = pytest.importorskip("torchjd.aggregation")
    for gradients in normal(10, 4, 3, seed=11):
        expected = 4 * aggregation.CAGrad(c=0.4)(gradients)
        torch.testing.assert_close(resolved(rule(c=0.4), gradients), expected, rtol=1e-2, atol=1e-2)


@pytest.mark.parametrize("rule", AGGREGATIONS[2:])
def test_a_goal_without_a_gradient_stops_nobody(rule: Any) -> None:
    one_zero: Tensor = DEGENERATE["all but one zero"]
    torch.testing.assert_close(resolved(rule(), one_zero), one_zero.sum(-2))


@pytest.mark.parametrize("c", [-0.1, 1.0, float("nan")])
@pytest.mark.parametrize("rule", AGGREGATIONS[2:])
def test_the_ball_must_not_hold_the_origin(rule: Any, c: float) -> None:
    with pytest.raises(OptionError, match="expected a number in"):
        rule(c=c)


@pytest.mark.parametrize("rule", (PCGrad, UPGrad, CAGrad))
def test_without_its_modules_it_says_what_to_install(
    rule: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(rule, "modules", ("no_such_module",))
    message = r"needs no_such_module: pip install 'aicon-torch\[peers\]'"
    with pytest.raises(ComparisonError, match=message):
        rule()


@pytest.mark.slow  # TorchInductor tries as well
@pytest.mark.parametrize("rule", AGGREGATIONS[:1])  # what cannot be traced is their common class
def test_a_policy_with_it_runs_uncompiled_with_a_warning(rule: Any) -> None:
    policy = lean("nav2d", preset="potential_field", resolution=rule())
    observations = drifting(4, (2,))
    expected, compiled = [], []

    memory = None
    for observation in observations:
        action, memory = policy.predict(observation, memory)
        expected.append(action)

    memory, same = None, policy.compile()
    with pytest.warns(RuntimeWarning, match="runs uncompiled"):
        for observation in observations:
            action, memory = same.predict(observation, memory)
            compiled.append(action)

    for one, other in zip(expected, compiled, strict=True):
        assert torch.equal(torch.as_tensor(one), torch.as_tensor(other))
