"""Exploration: against which gradient the dominant one is compared, and how."""

import math
from typing import Any

import pytest
import torch
from _inputs import (
    BATCHES,
    SCENARIOS,
    THREE,
    exploration_in_paper,
    explores,
    exploring_memory,
    fresh,
    lengths,
    literal,
    normal,
    pair,
    projection_in_paper,
    pursuit,
    resolve,
)
from torch import Tensor

from aicon_torch import NullspaceProjection

OPPOSING = literal(opponent="opposing")


def comparing(**options: Any) -> NullspaceProjection:
    """The paper's rule with another comparison."""
    return projection_in_paper(exploration=exploration_in_paper(**options))


# --- against whom


@pytest.mark.parametrize(
    ("opponent", "cosine", "conflicting"), [("second", 0.3162, False), ("opposing", -0.9923, True)]
)
def test_among_three_the_second_strongest_may_not_be_the_one_that_opposes(
    opponent: str, cosine: float, conflicting: bool
) -> None:
    total, state = resolve(literal(opponent=opponent), THREE)
    assert bool(state["exploring"]) == conflicting
    assert float(state["cosine"]) == pytest.approx(cosine, abs=1e-4)

    # Exploring, it moves in the nullspace of the first.
    assert (abs(float(total[0])) < 1e-9) == conflicting


@pytest.mark.parametrize("order", [(0, 1, 2), (1, 2, 0), (2, 1, 0), (2, 0, 1)], ids=str)
def test_the_partner_does_not_depend_on_the_order(order: tuple[int, ...]) -> None:
    total, state = resolve(OPPOSING, THREE)
    other, permuted = resolve(OPPOSING, THREE[list(order)])

    torch.testing.assert_close(total, other)
    torch.testing.assert_close(state["cosine"], permuted["cosine"])


def test_the_partner_is_the_strongest_of_those_that_oppose() -> None:
    """Not the one that opposes most."""
    stack = torch.tensor([[2.0, 0.0], [-0.5, 0.0], [-0.9, 0.9], [1.2, 1.2]], dtype=torch.float64)
    _, state = resolve(OPPOSING, stack)

    assert float(state["cosine"]) == pytest.approx(-math.sqrt(0.5))
    assert state["exploring"]


@pytest.mark.parametrize(("before", "cosine", "ratio", "after"), SCENARIOS)
def test_of_two_the_opposing_one_is_the_other(
    before: bool, cosine: float, ratio: float, after: bool
) -> None:
    """Then both rules begin and end conflicts alike, at the same two thresholds."""
    gradients = pair(cosine, ratio)
    memory = fresh(OPPOSING, gradients) | {"exploring": torch.tensor(before)}

    total, state = resolve(OPPOSING, gradients, memory)
    assert bool(state["exploring"]) == after

    against_second, _ = resolve(literal(), gradients, memory)
    torch.testing.assert_close(total, against_second)


def test_an_opposing_partner_is_kept_up_to_the_exit_cosine() -> None:
    """A conflict with the third lasts while it opposes by the exit cosine.

    By the enter cosine it would not begin.
    """
    cosines = (-0.5, -0.59, -0.61, -0.5, -0.41, -0.39, -0.5, -0.7)
    exploring = (False, False, True, True, True, False, False, True)

    memory = fresh(OPPOSING, THREE)
    for cosine, expected in zip(cosines, exploring, strict=True):
        third = 0.8 * torch.tensor([cosine, math.sqrt(1 - cosine**2)], dtype=torch.float64)
        _, memory = resolve(OPPOSING, torch.stack((THREE[0], THREE[1], third)), memory)
        assert bool(memory["exploring"]) == expected


# --- how much stronger


@pytest.mark.parametrize("opponent", ["second", "opposing"])
@pytest.mark.parametrize(("length", "conflicting"), [(0.34, True), (0.32, False)])
def test_the_ratio_is_to_the_opponent(opponent: str, length: float, conflicting: bool) -> None:
    """λ = 3.

    The strongest of the others counts in the text; the one that opposes, where it is the opponent.
    """
    stack = torch.tensor([[1.0, 0.0], [-length, 0.0], [0.0, 0.9]], dtype=torch.float64)
    rule = literal(opponent=opponent)

    exploring = explores(rule, stack, exploring_memory(stack, rule))
    assert exploring == (conflicting and opponent == "opposing")


@pytest.mark.parametrize("opponent", ["second", "opposing"])
@pytest.mark.parametrize(("ratio_of", "conflicting"), [("weights", True), ("magnitudes", False)])
def test_the_dominance_ratio_may_be_of_the_magnitudes(
    opponent: str, ratio_of: str, conflicting: bool
) -> None:
    """Lengths of ratio 3.33 have weights of ratio 2.4 with τ = 0.8.

    Only the former exceed λ = 3.
    """
    gradients = torch.tensor([[1.0, 0.0], [-0.3, 0.0]], dtype=torch.float64)
    assert explores(comparing(ratio_of=ratio_of, opponent=opponent), gradients) == conflicting


@pytest.mark.parametrize("scale", [1e-6, 1e6])
@pytest.mark.parametrize(("ratio", "conflicting"), [(2.99, True), (3.01, False)])
def test_a_ratio_of_magnitudes_does_not_depend_on_their_unit(
    scale: float, ratio: float, conflicting: bool
) -> None:
    rule = comparing(ratio_of="magnitudes", opponent="opposing")
    assert explores(rule, scale * pair(-0.9, ratio)) == conflicting


@pytest.mark.parametrize("exploring", [False, True])
@pytest.mark.parametrize(
    "stack",
    [
        torch.tensor([[1.0, 0.0], [0.5, 0.5], [0.2, -0.9]], dtype=torch.float64),
        torch.tensor([[1.0, 0.0], [0.0, 0.0], [0.0, 0.0]], dtype=torch.float64),
        torch.zeros(3, 2, dtype=torch.float64),
    ],
    ids=["none opposes", "the others are zero", "all are zero"],
)
def test_where_nothing_opposes_there_is_no_conflict(stack: Tensor, exploring: bool) -> None:
    memory = fresh(OPPOSING, stack) | {"exploring": torch.tensor(exploring)}

    total, state = resolve(OPPOSING, stack, memory)
    assert not state["exploring"]

    downhill, _ = resolve(pursuit(), stack, memory)
    assert torch.equal(total, downhill)


# --- against plain loops


def in_conflict(gradients: Tensor, exploring: bool, ratio_of: str) -> bool:
    """Whether a stack ``(n, d)`` is in conflict, with the thresholds −0.3 and −0.1 and λ = 2."""
    norms = lengths(gradients)
    compared = norms if ratio_of == "magnitudes" else torch.softmax(norms / 0.8, dim=-1)

    first = int(norms.argmax())
    cosines = torch.cosine_similarity(gradients[first], gradients, dim=-1)
    threshold = -0.1 if exploring else -0.3

    opposing = [i for i in range(len(norms)) if i != first and cosines[i] <= threshold]
    if not opposing:
        return False
    return bool(compared[first] <= 2.0 * compared[opposing].max())


@pytest.mark.parametrize("batch", BATCHES, ids=str)
@pytest.mark.parametrize("ratio_of", ["weights", "magnitudes"])
def test_partners_are_found_row_by_row(batch: tuple[int, ...], ratio_of: Any) -> None:
    """On random stacks of four."""
    thresholds = {"enter_cosine": -0.3, "exit_cosine": -0.1, "ratio": 2.0}
    exploration = exploration_in_paper(**thresholds, opponent="opposing", ratio_of=ratio_of)
    rule = projection_in_paper(margin=0.0, exploration=exploration)

    stack = normal(*batch, 20, 4, 2, seed=3)
    before = normal(*batch, 20, seed=8) > 0
    _, state = resolve(rule, stack, fresh(rule, stack) | {"exploring": before})

    rows = zip(stack.reshape(-1, 4, 2), before.flatten().tolist(), strict=True)
    expected = [in_conflict(gradients, exploring, ratio_of) for gradients, exploring in rows]
    assert state["exploring"].flatten().tolist() == expected
    assert 0 < sum(expected) < len(expected)
