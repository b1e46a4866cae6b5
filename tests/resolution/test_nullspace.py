"""Resolutions: properties of the rule from a stack of gradients to one, over a table of stacks."""

import math
from typing import Any

import pytest
import torch
from _asserts import assert_orthogonal, selection
from _inputs import BATCHES, DEGENERATE, DTYPES, RANDOM, STACKS, fresh, meeting, normal
from torch import Tensor

from aicon_torch import Escape, Exploration, NullspaceProjection, OptionError, SteepestPath, Sum

ALONE: dict[str, Any] = {"exploration": None}
"""Options without exploration, so that every result is a resolved sum."""
TEXT: dict[str, Any] = {"temperature": None} | ALONE
"""Options with which the gradients keep their magnitudes."""
PROJECTORS: tuple[Any, ...] = ("orthogonal", "qr", "pinv")


def resolved(rule: Any, gradients: Tensor, memory: dict[str, Tensor] | None = None) -> Tensor:
    total: Tensor = rule(meeting(gradients), fresh(rule, gradients) if memory is None else memory)[0]
    return total


def ranks(rule: NullspaceProjection, gradients: Tensor, memory: dict[str, Tensor] | None = None) -> Tensor:
    return rule(meeting(gradients), fresh(rule, gradients) if memory is None else memory)[1]["rank"]


def selected(rule: NullspaceProjection, gradients: Tensor) -> tuple[Tensor, Tensor]:
    """The projected gradient of each rank, ``(*B, k, d)``, and the candidates ``(*B, k)``."""
    strengths = torch.linalg.vector_norm(gradients, dim=-1)
    return rule.resolve(gradients, strengths, fresh(rule, gradients)["rank"])


# --- every rule, every stack


@pytest.mark.parametrize("dtype", DTYPES, ids=str)
@pytest.mark.parametrize("stack", STACKS.values(), ids=STACKS.keys())
def test_result_is_finite_and_of_the_right_shape_and_type(stack: Tensor, dtype: torch.dtype) -> None:
    gradients = stack.to(dtype)
    rules = (
        Sum(),
        SteepestPath(),
        NullspaceProjection(**ALONE),
        NullspaceProjection(**TEXT),
        NullspaceProjection(exploration=Exploration()),
        *(NullspaceProjection(projector=name, **ALONE) for name in (*PROJECTORS, "none")),
    )
    for rule in rules:
        total, memory = rule(meeting(gradients), fresh(rule, gradients))
        assert total.shape == gradients.shape[:-2] + gradients.shape[-1:]
        assert total.dtype == dtype
        assert total.isfinite().all()
        assert memory.keys() == fresh(rule, gradients).keys()
        for name, value in fresh(rule, gradients).items():
            assert memory[name].shape == value.shape and memory[name].dtype == value.dtype


@pytest.mark.parametrize("stack", STACKS.values(), ids=STACKS.keys())
def test_normalised_result_is_bounded(stack: Tensor) -> None:
    """Orthogonal vectors of lengths that sum to at most one."""
    assert (torch.linalg.vector_norm(resolved(NullspaceProjection(**ALONE), stack), dim=-1) <= 1 + 1e-12).all()


@pytest.mark.parametrize("stack", RANDOM.values(), ids=RANDOM.keys())
@pytest.mark.parametrize("options", [ALONE, TEXT, {"exploration": Exploration()}], ids=["softmax", "text", "exploring"])
def test_rows_of_a_batch_are_resolved_alone(stack: Tensor, options: dict[str, Any]) -> None:
    rule = NullspaceProjection(**options)
    flat = stack.reshape(-1, *stack.shape[-2:])
    together = resolved(rule, stack).reshape(-1, stack.shape[-1])
    alone = torch.stack([resolved(rule, row) for row in flat])
    torch.testing.assert_close(together, alone, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("stack", RANDOM.values(), ids=RANDOM.keys())
@pytest.mark.parametrize(
    "rule", [Sum(), SteepestPath(), NullspaceProjection(**ALONE), NullspaceProjection(**TEXT)], ids=repr
)
def test_order_of_the_candidates_does_not_matter(stack: Tensor, rule: Any) -> None:
    order = torch.randperm(stack.shape[-2], generator=torch.Generator().manual_seed(1))
    permuted = stack[..., order, :]
    torch.testing.assert_close(resolved(rule, permuted), resolved(rule, stack), rtol=1e-10, atol=1e-12)
    if isinstance(rule, NullspaceProjection):
        assert torch.equal(order[ranks(rule, permuted)], ranks(rule, stack))


@pytest.mark.parametrize("stack", RANDOM.values(), ids=RANDOM.keys())
@pytest.mark.parametrize("rule", [Sum(), SteepestPath(), NullspaceProjection(**TEXT)], ids=["sum", "steepest", "text"])
@pytest.mark.parametrize("factor", [1e-6, 3.0, 1e6])
def test_without_softmax_the_result_scales_with_the_gradients(stack: Tensor, rule: Any, factor: float) -> None:
    torch.testing.assert_close(resolved(rule, factor * stack), factor * resolved(rule, stack), rtol=1e-10, atol=0.0)


@pytest.mark.parametrize("stack", RANDOM.values(), ids=RANDOM.keys())
@pytest.mark.parametrize(
    "rule", [Sum(), SteepestPath(), NullspaceProjection(**ALONE), NullspaceProjection(**TEXT)], ids=repr
)
def test_result_turns_with_the_gradients(stack: Tensor, rule: Any) -> None:
    """No axis is special: a rotation of all gradients rotates the result."""
    rotation = torch.linalg.qr(normal(stack.shape[-1], stack.shape[-1], seed=3)).Q
    torch.testing.assert_close(
        resolved(rule, stack @ rotation), resolved(rule, stack) @ rotation, rtol=1e-10, atol=1e-12
    )


@pytest.mark.parametrize("stack", RANDOM.values(), ids=RANDOM.keys())
def test_sum_adds_and_steepest_path_takes_the_longest(stack: Tensor) -> None:
    torch.testing.assert_close(resolved(Sum(), stack), stack.sum(-2))
    lengths = torch.linalg.vector_norm(stack, dim=-1)
    longest = resolved(SteepestPath(), stack)
    torch.testing.assert_close(torch.linalg.vector_norm(longest, dim=-1), lengths.amax(-1))
    assert (longest.unsqueeze(-2) == stack).all(-1).any(-1).all()


# --- nullspace projection


@pytest.mark.parametrize("stack", STACKS.values(), ids=STACKS.keys())
@pytest.mark.parametrize("projector", PROJECTORS)
def test_resolved_gradients_are_mutually_orthogonal(stack: Tensor, projector: Any) -> None:
    vectors, _ = selected(NullspaceProjection(projector=projector, **TEXT), stack)
    lengths = torch.linalg.vector_norm(vectors, dim=-1)
    largest = lengths.amax(-1, keepdim=True)
    assert_orthogonal(vectors, (largest * largest).unsqueeze(-1))
    if any(stack is random for random in RANDOM.values()):  # elsewhere a remainder of rounding is no direction
        assert_orthogonal(vectors, lengths.unsqueeze(-1) * lengths.unsqueeze(-2))


@pytest.mark.parametrize("stack", STACKS.values(), ids=STACKS.keys())
def test_a_gradient_never_changes_what_those_before_it_decided(stack: Tensor) -> None:
    """What rank i adds is orthogonal to every *original* gradient of a higher rank.

    So to first order the motion −Σ lowers the cost of the top gradient exactly as its own descent would, and what any
    rank adds to the motion leaves the costs of all ranks above it where they are.
    """
    vectors, order = selected(NullspaceProjection(**TEXT), stack)
    original = stack.take_along_dim(order.unsqueeze(-1), dim=-2)
    scale = torch.linalg.vector_norm(stack, dim=-1).amax(-1)
    for rank in range(1, vectors.shape[-2]):
        work = (vectors[..., rank : rank + 1, :] * original[..., :rank, :]).sum(-1)
        assert (work.abs() <= 1e-12 * (scale**2).unsqueeze(-1)).all()
    total = vectors.sum(-2)
    for rank in range(vectors.shape[-2]):  # the sum's part along each resolved gradient is that gradient itself
        part = (total * vectors[..., rank, :]).sum(-1)
        own = (vectors[..., rank, :] ** 2).sum(-1)
        assert ((part - own).abs() <= 1e-12 * scale**2).all()
        assert (part >= -1e-12 * scale**2).all()


@pytest.mark.parametrize("stack", RANDOM.values(), ids=RANDOM.keys())
@pytest.mark.parametrize("margin", [0.0, 0.1])
def test_selection_agrees_with_plain_loops(stack: Tensor, margin: float) -> None:
    """Eq. 7-8 written out, projecting onto the complement of a span by least squares."""
    rule = NullspaceProjection(margin=margin, **TEXT)
    flat = stack.reshape(-1, *stack.shape[-2:])
    depth = min(stack.shape[-2:])
    held = torch.randint(-1, stack.shape[-2], (len(flat), depth), generator=torch.Generator().manual_seed(0))
    taken, order = rule.resolve(flat, torch.linalg.vector_norm(flat, dim=-1), held)
    for row, gradients in enumerate(flat):
        vectors, chosen = selection(gradients, held[row], margin)
        assert order[row].tolist() == chosen
        torch.testing.assert_close(taken[row].sum(0), vectors.sum(0), rtol=1e-10, atol=1e-12)


@pytest.mark.parametrize("stack", STACKS.values(), ids=STACKS.keys())
@pytest.mark.parametrize("options", [ALONE, TEXT], ids=["softmax", "text"])
def test_the_three_projectors_are_equal(stack: Tensor, options: dict[str, Any]) -> None:
    orthogonal, qr, pinv = (resolved(NullspaceProjection(projector=name, **options), stack) for name in PROJECTORS)
    scale = max(float(stack.abs().max()), 1e-30) if options is TEXT else 1.0
    torch.testing.assert_close(orthogonal / scale, qr / scale, rtol=1e-10, atol=1e-10)
    torch.testing.assert_close(orthogonal / scale, pinv / scale, rtol=1e-10, atol=1e-10)


@pytest.mark.parametrize("dimension", [1, 2, 4])
def test_orthogonal_gradients_are_simply_added(dimension: int) -> None:
    stack = torch.linalg.qr(normal(3, dimension, dimension)).Q * torch.arange(1.0, dimension + 1).reshape(-1, 1)
    torch.testing.assert_close(resolved(NullspaceProjection(**TEXT), stack), stack.sum(-2), rtol=1e-10, atol=1e-12)


def test_parallel_gradients_are_not_counted_twice() -> None:
    """In one dimension, or along one line, the strongest alone acts."""
    for stack in (normal(4, 5, 1), normal(4, 5, 1) * normal(3)):
        longest = resolved(SteepestPath(), stack)
        torch.testing.assert_close(resolved(NullspaceProjection(**TEXT), stack), longest, rtol=1e-9, atol=1e-9)


def test_projection_removes_what_would_interfere() -> None:
    """Two gradients in the plane, by hand: (3, 4) leads, (1, 0) loses its component along it."""
    stack = torch.tensor([[1.0, 0.0], [3.0, 4.0]], dtype=torch.float64)
    expected = torch.tensor([3.0 + 0.64, 4.0 - 0.48], dtype=torch.float64)
    torch.testing.assert_close(resolved(NullspaceProjection(**TEXT), stack), expected)


def test_no_projection_adds_the_gradients_as_they_are() -> None:
    for count in (2, 6):
        stack = normal(3, count, 4)
        torch.testing.assert_close(resolved(NullspaceProjection(projector="none", **TEXT), stack), stack.sum(-2))


@pytest.mark.parametrize("batch", BATCHES, ids=str)
def test_a_single_gradient_passes(batch: tuple[int, ...]) -> None:
    stack = normal(*batch, 1, 3)
    torch.testing.assert_close(resolved(NullspaceProjection(**TEXT), stack), stack[..., 0, :])
    unit = stack[..., 0, :] / stack[..., 0, :].norm(dim=-1, keepdim=True)
    torch.testing.assert_close(resolved(NullspaceProjection(**ALONE), stack), unit)


# --- softmax


@pytest.mark.parametrize("temperature", [0.1, 0.8, 5.0])
def test_weights_are_the_softmax_of_the_magnitudes(temperature: float) -> None:
    norms = normal(3, 4).abs() + 0.1
    weights = NullspaceProjection(temperature=temperature, **ALONE).weigh(norms)
    expected = torch.exp(norms / temperature) / torch.exp(norms / temperature).sum(-1, keepdim=True)
    torch.testing.assert_close(weights, expected)
    torch.testing.assert_close(weights.sum(-1), torch.ones(3, dtype=torch.float64))
    assert torch.equal(weights.argsort(-1), norms.argsort(-1))


def test_two_gradients_are_normalised_before_projection() -> None:
    """Sect. "Stabilizing the Control Signal" by hand: lengths 2 and 1, at right angles, τ = 0.8."""
    stack = torch.tensor([[2.0, 0.0], [0.0, 1.0]], dtype=torch.float64)
    share = 1.0 / (1.0 + math.exp(-1.0 / 0.8))
    expected = torch.tensor([share, 1.0 - share], dtype=torch.float64)
    torch.testing.assert_close(resolved(NullspaceProjection(**ALONE), stack), expected)


def test_magnitudes_stay_without_temperature() -> None:
    norms = normal(3, 4).abs()
    assert torch.equal(NullspaceProjection(**TEXT).weigh(norms), norms)


@pytest.mark.parametrize("dtype", DTYPES, ids=str)
@pytest.mark.parametrize("length", [1e-10, 1e-25, 1e-40, 1e-200, 1e-310])
def test_a_vanishing_gradient_never_outgrows_its_weight(dtype: torch.dtype, length: float) -> None:
    """Lengths whose squares underflow included: the literal text gives them weight, but at most as unit vectors."""
    stack = torch.tensor([[length, 2 * length], [1.0, 0.0]], dtype=torch.float64).to(dtype)
    total = resolved(NullspaceProjection(**ALONE), stack)
    assert total[0] > 0.5
    assert total.norm() <= 1.0 + 1e-6


# --- relative magnitudes


@pytest.mark.parametrize("stack", RANDOM.values(), ids=RANDOM.keys())
@pytest.mark.parametrize("scale", [1e-9, 1e-3, 1e9])
@pytest.mark.parametrize("options", [ALONE, {}], ids=["alone", "exploring"])
def test_relative_weights_do_not_depend_on_the_unit(stack: Tensor, scale: float, options: dict[str, Any]) -> None:
    rule = NullspaceProjection(relative=True, **options)
    torch.testing.assert_close(resolved(rule, scale * stack), resolved(rule, stack), rtol=1e-9, atol=1e-12)
    norms = torch.linalg.vector_norm(stack, dim=-1)
    torch.testing.assert_close(rule.weigh(scale * norms), rule.weigh(norms))
    if stack.shape[-2] > 1:  # else there is nothing to weigh against
        assert not torch.allclose(NullspaceProjection(**ALONE).weigh(norms), rule.weigh(norms), rtol=1e-3)


@pytest.mark.parametrize("temperature", [0.1, 0.8, 5.0])
def test_relative_weights_are_the_softmax_of_shares_of_the_largest(temperature: float) -> None:
    norms = 30.0 * normal(3, 4).abs()
    weights = NullspaceProjection(temperature=temperature, relative=True, **ALONE).weigh(norms)
    shares = norms / norms.amax(-1, keepdim=True)
    torch.testing.assert_close(weights, torch.softmax(shares / temperature, dim=-1))
    torch.testing.assert_close(weights.sum(-1), torch.ones(3, dtype=torch.float64))
    assert torch.equal(weights.argsort(-1), norms.argsort(-1))
    largest = weights.amax(-1) / weights.amin(-1)
    assert (largest <= math.exp(1.0 / temperature) * (1 + 1e-12)).all()


@pytest.mark.parametrize("dtype", DTYPES, ids=str)
@pytest.mark.parametrize("stack", DEGENERATE.values(), ids=DEGENERATE.keys())
def test_relative_weights_of_degenerate_stacks_are_finite(stack: Tensor, dtype: torch.dtype) -> None:
    gradients = stack.to(dtype)
    norms = torch.linalg.vector_norm(gradients, dim=-1)
    for options in (ALONE, {}):
        rule = NullspaceProjection(relative=True, **options)
        assert rule.weigh(norms).isfinite().all()
        total, memory = rule(meeting(gradients), fresh(rule, gradients))
        assert total.isfinite().all() and all(value.isfinite().all() for value in memory.values())
        assert (torch.linalg.vector_norm(total, dim=-1) <= 1 + 1e-6).all()
        if not gradients.any():
            assert not total.any()


def test_without_a_softmax_there_is_nothing_relative() -> None:
    for stack in RANDOM.values():
        assert torch.equal(
            resolved(NullspaceProjection(relative=True, **TEXT), stack), resolved(NullspaceProjection(**TEXT), stack)
        )


# --- magnitudes between meetings


@pytest.mark.parametrize("stack", RANDOM.values(), ids=RANDOM.keys())
def test_between_meetings_the_leading_gradient_keeps_its_magnitude(stack: Tensor) -> None:
    """The weights compare those that met here; further on, magnitudes are compared with those of others."""
    rule, plain = NullspaceProjection(**ALONE), NullspaceProjection(restore_magnitude=False, **ALONE)
    memory = fresh(rule, stack)
    onward, state = rule(meeting(stack, final=False), memory)
    first = stack.take_along_dim(state["rank"][..., :1, None], -2).squeeze(-2)
    length = first.norm(dim=-1)
    torch.testing.assert_close((onward * first).sum(-1) / length, length)
    last, _ = rule(meeting(stack, final=True), memory)
    weight = rule.weigh(torch.linalg.vector_norm(stack, dim=-1)).amax(-1)
    torch.testing.assert_close(onward, last * (length / weight).unsqueeze(-1))
    for final in (True, False):
        assert torch.equal(plain(meeting(stack, final=final), memory)[0], last)


def test_between_meetings_exploration_is_as_strong_as_what_led_there() -> None:
    stack = torch.tensor([[2.0, 0.0], [-1.9, 0.3]], dtype=torch.float64)
    rule = NullspaceProjection()
    for final, length in ((True, 1.0), (False, 2.0)):
        total, state = rule(meeting(stack, final=final), fresh(rule, stack))
        assert state["exploring"]
        assert float(total.norm()) == pytest.approx(length)


@pytest.mark.parametrize("stack", DEGENERATE.values(), ids=DEGENERATE.keys())
def test_restored_magnitudes_are_finite(stack: Tensor) -> None:
    for options in (ALONE, {"relative": True}, {}):
        rule = NullspaceProjection(**options)
        assert rule(meeting(stack, final=False), fresh(rule, stack))[0].isfinite().all()


# --- hysteresis


def test_what_has_vanished_holds_no_rank() -> None:
    stack = torch.zeros(2, 4, 3, dtype=torch.float64)
    stack[0, 2] = torch.tensor([0.0, 1.0, 2.0])
    rule = NullspaceProjection(**TEXT)
    assert ranks(rule, stack).tolist() == [[2, -1, -1], [-1, -1, -1]]
    assert not resolved(rule, stack)[1].any()


def test_a_rank_that_nobody_held_favours_nobody() -> None:
    """A gradient that appears is not second for having been zero before."""
    rule = NullspaceProjection(**TEXT)
    stack = torch.tensor([[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 3.0]], dtype=torch.float64)
    _, memory = rule(meeting(stack), fresh(rule, stack))
    stack[0, 0], stack[1, 1] = 1.0, 1.05
    for order in ([0, 1, 2], [1, 0, 2]):
        held = rule(meeting(stack[order]), memory)[1]["rank"]
        assert held[:2].tolist() == [2, order.index(1)]


def with_lengths(*lengths: float, directions: Tensor) -> Tensor:
    return directions * torch.tensor(lengths, dtype=torch.float64).reshape(-1, 1)


@pytest.mark.parametrize(("factor", "takes_over"), [(1.05, False), (1.0999, False), (1.1001, True), (1.15, True)])
@pytest.mark.parametrize("margin", [0.1])
def test_a_competitor_takes_the_lead_only_beyond_the_margin(factor: float, takes_over: bool, margin: float) -> None:
    rule = NullspaceProjection(margin=margin, **TEXT)
    directions = torch.tensor([[1.0, 0.0], [0.6, 0.8]], dtype=torch.float64)
    _, memory = rule(meeting(with_lengths(1.0, 0.9, directions=directions)), fresh(rule, directions))
    assert memory["rank"].tolist() == [0, 1]
    _, after = rule(meeting(with_lengths(1.0, factor, directions=directions)), memory)
    assert (after["rank"][0] == 1) == takes_over
    assert ranks(NullspaceProjection(margin=0.0, **TEXT), with_lengths(1.0, factor, directions=directions))[0] == 1


@pytest.mark.parametrize(("factor", "takes_over"), [(1.05, False), (1.15, True)])
def test_the_margin_holds_at_every_rank(factor: float, takes_over: bool) -> None:
    """The second rank is held by the strength that is left after projection."""
    rule = NullspaceProjection(**TEXT)
    directions = torch.eye(3, dtype=torch.float64)
    _, memory = rule(meeting(with_lengths(5.0, 1.0, 0.9, directions=directions)), fresh(rule, directions))
    assert memory["rank"].tolist() == [0, 1, 2]
    _, after = rule(meeting(with_lengths(5.0, 1.0, factor, directions=directions)), memory)
    assert after["rank"].tolist() == ([0, 2, 1] if takes_over else [0, 1, 2])


def test_the_margin_acts_on_the_normalised_strengths() -> None:
    """With a softmax, a competitor that is 15 % longer is only a few percent stronger."""
    rule = NullspaceProjection(temperature=0.8, **ALONE)
    directions = torch.tensor([[1.0, 0.0], [0.6, 0.8]], dtype=torch.float64)
    _, memory = rule(meeting(with_lengths(0.4, 0.3, directions=directions)), fresh(rule, directions))
    for length, takes_over in ((0.4 + 0.8 * math.log(1.05), False), (0.4 + 0.8 * math.log(1.15), True)):
        _, after = rule(meeting(with_lengths(0.4, length, directions=directions)), memory)
        assert (after["rank"][0] == 1) == takes_over


def test_hysteresis_is_of_each_row() -> None:
    rule = NullspaceProjection(**TEXT)
    stack = torch.tensor([[1.0, 0.0], [0.63, 0.84]], dtype=torch.float64).expand(2, 2, 2)
    _, memory = rule(meeting(stack), {"rank": torch.tensor([[0, 1], [1, 0]])})
    assert memory["rank"].tolist() == [[0, 1], [1, 0]]


# --- bad options


@pytest.mark.parametrize(
    ("options", "culprit"),
    [
        ({"temperature": 0.0}, "temperature"),
        ({"temperature": -1.0}, "temperature"),
        ({"temperature": math.nan}, "temperature"),
        ({"margin": -0.1}, "margin"),
        ({"projector": "ortho"}, "'orthogonal', 'qr', 'pinv', 'none'"),
    ],
)
def test_bad_options_are_named(options: dict[str, Any], culprit: str) -> None:
    with pytest.raises(OptionError, match=culprit):
        NullspaceProjection(**options)


def test_the_defaults_are_those_of_the_paper() -> None:
    rule = NullspaceProjection()
    assert (rule.temperature, rule.margin) == (0.8, 0.1)
    assert (rule.relative, rule.by_row) == (False, False)
    assert rule.exploration is not None and rule.exploration.escape == Escape()
    assert (rule.exploration.enter_cosine, rule.exploration.exit_cosine, rule.exploration.ratio) == (-0.6, -0.4, 3.0)
    assert (rule.exploration.partner, rule.exploration.ratio_of) == ("second", "weights")
