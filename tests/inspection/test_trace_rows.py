"""The trace of a batch is the traces of its rows, and an explanation is one of them."""

import dataclasses
from collections.abc import Sequence

import pytest
import torch
from _asserts import rollout
from _inputs import drifting, navigation
from torch import Tensor

from aicon_torch import StepTrace
from aicon_torch.inspection import QuantityTrace
from aicon_torch.inspection.explanation import Candidate


def assert_row(whole: StepTrace, alone: StepTrace, row: int) -> None:
    """A row of a batch's trace is that of the row alone."""
    for name, value in alone.values.items():
        torch.testing.assert_close(whole.values[name][row], value)
    for name, cost in alone.costs.items():
        torch.testing.assert_close(whole.costs[name][row], cost)

    for name, there in alone.quantities.items():
        assert_row_of_quantity(whole.quantities[name], there, row)


def assert_row_of_quantity(whole: QuantityTrace, alone: QuantityTrace, row: int) -> None:
    for field in dataclasses.fields(QuantityTrace):
        ours, expected = getattr(whole, field.name), getattr(alone, field.name)
        if isinstance(expected, Tensor):
            torch.testing.assert_close(ours[row], expected)
        else:
            assert ours == expected


@pytest.mark.parametrize("preset", ["aicon", "paper_literal", "steepest", "potential_field"])
def test_a_batched_trace_is_the_traces_of_its_rows(preset: str) -> None:
    policy, recorded = navigation(preset), drifting(6, (3,))
    whole = policy.trace(rollout(policy, recorded)[-1])

    for row in range(3):
        readings_of_row = [{key: value[row] for key, value in r.items()} for r in recorded]
        assert_row(whole, policy.trace(rollout(policy, readings_of_row)[-1]), row)


# --- beside the explanation


def test_an_explanation_is_a_row_of_the_trace() -> None:
    policy = navigation()
    memory = rollout(policy, drifting(20, (3,)))[-1]
    trace = policy.trace(memory)

    for row in range(3):
        report = policy.explain(memory, row)
        for name, action in report.action.items():
            assert action == tuple(trace.values[name][row].tolist())
        for name, goal in report.goals.items():
            assert goal.cost == pytest.approx(float(trace.costs[name][row]))
        for name, quantity in report.quantities.items():
            assert_explains(quantity.candidates, trace.quantities[name], row)
            assert quantity.exploring == bool(trace.quantities[name].exploring[row])


def assert_explains(candidates: Sequence[Candidate], there: QuantityTrace, row: int) -> None:
    """Path, magnitude and rank of each candidate; no rank is −1 in the trace."""
    ranks = [None if rank < 0 else rank for rank in there.ranks[row].tolist()]
    expected = list(zip(there.labels, there.magnitudes[row].tolist(), ranks, strict=True))
    assert [(c.path, c.magnitude, c.rank) for c in candidates] == expected
