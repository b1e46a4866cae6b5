"""Exploration: when a conflict begins and ends, where it leads, and what each escape option does."""

import math
from collections.abc import Callable
from typing import Any

import pytest
import torch
from _asserts import rollout
from _inputs import BATCHES, DTYPES, fresh, meeting, normal
from torch import Tensor

from aicon_torch import (
    ActionLaw,
    Actuator,
    Escape,
    Exploration,
    Deterministic,
    Goal,
    NullspaceProjection,
    OptionError,
    Policy,
    Sensor,
    WorldModel,
    make_policy,
)

Memory = dict[str, Tensor]


def rule(escape: Escape | None = None, **options: Any) -> NullspaceProjection:
    """Magnitudes as they are and no hysteresis of ranks, so that the stack says exactly what conflicts."""
    return NullspaceProjection(temperature=None, margin=0.0, exploration=Exploration(escape=escape, **options))


def pair(cosine: float, ratio: float = 1.5, dtype: torch.dtype = torch.float64) -> Tensor:
    """Two gradients in the plane with a given cosine, the first longer by a given ratio."""
    second = torch.tensor([cosine, math.sqrt(1.0 - cosine**2)], dtype=torch.float64)
    return torch.stack((ratio * torch.tensor([1.0, 0.0], dtype=torch.float64), second)).to(dtype)


def exploring_memory(gradients: Tensor, of: NullspaceProjection, **known: Tensor) -> Memory:
    return fresh(of, gradients) | {"exploring": torch.ones(gradients.shape[:-2], dtype=torch.bool)} | known


def conflict(*batch: int, size: int = 3, seed: int = 0, dtype: torch.dtype = torch.float64) -> Tensor:
    """Two gradients that oppose each other, up to a little, and a weak third one."""
    first, noise, third = normal(3, *batch, size, seed=seed, dtype=dtype)
    second = -0.8 * first + 0.2 * torch.linalg.vector_norm(first, dim=-1, keepdim=True) * unit(noise)
    return torch.stack((first, second, 0.05 * third), dim=-2)


def unit(vector: Tensor) -> Tensor:
    return vector / torch.linalg.vector_norm(vector, dim=-1, keepdim=True)


# --- when


SCENARIOS = [
    # exploring before, cosine, ratio → exploring after
    (False, -0.59, 1.5, False),
    (False, -0.61, 1.5, True),
    (False, -1.0, 1.0, True),
    (False, -0.61, 2.99, True),
    (False, -0.61, 3.01, False),
    (False, -1.0, 10.0, False),
    (False, -0.5, 1.5, False),
    (False, 0.0, 1.5, False),
    (False, 0.9, 1.5, False),
    (True, -0.61, 1.5, True),
    (True, -0.5, 1.5, True),
    (True, -0.41, 1.5, True),
    (True, -0.39, 1.5, False),
    (True, 0.9, 1.5, False),
    (True, -0.5, 2.99, True),
    (True, -0.5, 3.01, False),
    (True, -1.0, 3.01, False),
]


@pytest.mark.parametrize(("before", "cosine", "ratio", "after"), SCENARIOS)
@pytest.mark.parametrize("dtype", DTYPES, ids=str)
def test_a_conflict_begins_and_ends(before: bool, cosine: float, ratio: float, after: bool, dtype: torch.dtype) -> None:
    gradients = pair(cosine, ratio, dtype)
    memory = fresh(rule(), gradients) | {"exploring": torch.tensor(before)}
    total, state = rule()(meeting(gradients), memory)
    assert bool(state["exploring"]) == after
    assert float(state["cosine"]) == pytest.approx(cosine, abs=1e-6)
    pursuit, _ = NullspaceProjection(temperature=None, margin=0.0, exploration=None)(meeting(gradients), memory)
    assert torch.equal(total, pursuit) != after


def test_rows_decide_alone() -> None:
    """All scenarios as one batch."""
    gradients = torch.stack([pair(cosine, ratio) for _, cosine, ratio, _ in SCENARIOS])
    memory = fresh(rule(), gradients) | {"exploring": torch.tensor([before for before, *_ in SCENARIOS])}
    _, state = rule()(meeting(gradients), memory)
    assert state["exploring"].tolist() == [after for *_, after in SCENARIOS]


def test_a_third_gradient_decides_only_as_one_of_the_two_strongest() -> None:
    opposed = torch.tensor([[1.0, 0.0], [-0.9, 0.0]], dtype=torch.float64)
    weak, strong = torch.tensor([[[0.0, 0.5]], [[0.0, 0.95]]], dtype=torch.float64)
    for third, conflicting in ((weak, True), (strong, False)):
        gradients = torch.cat((opposed, third))
        assert bool(rule()(meeting(gradients), fresh(rule(), gradients))[1]["exploring"]) == conflicting


def test_the_asymmetric_thresholds_prevent_chattering() -> None:
    """A cosine that drifts up and down through both thresholds."""
    cosines = [-0.5, -0.59, -0.61, -0.55, -0.45, -0.41, -0.39, -0.45, -0.55, -0.59, -0.65, -0.5]
    memory = fresh(rule(), pair(0.0))
    seen = []
    for cosine in cosines:
        _, memory = rule()(meeting(pair(cosine)), memory)
        seen.append(bool(memory["exploring"]))
    assert seen == [False, False, True, True, True, True, False, False, False, False, True, True]


def test_the_dominance_ratio_is_of_the_normalised_magnitudes() -> None:
    """With τ = 0.8 lengths of 1 and 0.3 have weights of ratio 2.4, so that λ = 3 does not end the conflict."""
    gradients = torch.tensor([[1.0, 0.0], [-0.3, 0.0]], dtype=torch.float64)
    softmax = NullspaceProjection(exploration=Exploration())
    assert softmax(meeting(gradients), fresh(softmax, gradients))[1]["exploring"]
    assert not rule()(meeting(gradients), fresh(rule(), gradients))[1]["exploring"]


# --- against whom

THREE = torch.tensor([[1.0, 0.0], [0.3, 0.9], [-0.8, 0.1]], dtype=torch.float64)
"""The second strongest is nearly at right angles to the first; the third opposes it."""


def test_among_three_the_second_strongest_may_not_be_the_one_that_opposes() -> None:
    for partner, cosine, conflicting in (("second", 0.3162, False), ("opposing", -0.9923, True)):
        of = rule(partner=partner)
        total, state = of(meeting(THREE), fresh(of, THREE))
        assert bool(state["exploring"]) == conflicting
        assert float(state["cosine"]) == pytest.approx(cosine, abs=1e-4)
        assert (abs(float(total[0])) < 1e-9) == conflicting  # it moves in the nullspace of the first


@pytest.mark.parametrize("order", [(0, 1, 2), (1, 2, 0), (2, 1, 0), (2, 0, 1)], ids=str)
def test_the_partner_does_not_depend_on_the_order(order: tuple[int, ...]) -> None:
    of = rule(partner="opposing")
    first, second = (of(meeting(stack), fresh(of, stack)) for stack in (THREE, THREE[list(order)]))
    torch.testing.assert_close(first[0], second[0])
    torch.testing.assert_close(first[1]["cosine"], second[1]["cosine"])


def test_the_partner_is_the_strongest_of_those_that_oppose() -> None:
    """Not the one that opposes most."""
    stack = torch.tensor([[2.0, 0.0], [-0.5, 0.0], [-0.9, 0.9], [1.2, 1.2]], dtype=torch.float64)
    of = rule(partner="opposing")
    _, state = of(meeting(stack), fresh(of, stack))
    assert float(state["cosine"]) == pytest.approx(-math.sqrt(0.5))
    assert state["exploring"]


@pytest.mark.parametrize("scenario", SCENARIOS, ids=str)
def test_of_two_the_opposing_one_is_the_other(scenario: tuple[bool, float, float, bool]) -> None:
    """Then both rules begin and end conflicts alike, at the same two thresholds."""
    before, cosine, ratio, after = scenario
    gradients = pair(cosine, ratio)
    of = rule(partner="opposing")
    memory = fresh(of, gradients) | {"exploring": torch.tensor(before)}
    total, state = of(meeting(gradients), memory)
    assert bool(state["exploring"]) == after
    torch.testing.assert_close(total, rule()(meeting(gradients), memory)[0])


def test_an_opposing_partner_is_kept_up_to_the_exit_cosine() -> None:
    """A conflict with the third lasts while it opposes by the exit cosine; by the enter cosine it would not begin."""
    of = rule(partner="opposing")
    seen = []
    memory = fresh(of, THREE)
    for cosine in (-0.5, -0.59, -0.61, -0.5, -0.41, -0.39, -0.5, -0.7):
        third = 0.8 * torch.tensor([cosine, math.sqrt(1 - cosine**2)], dtype=torch.float64)
        _, memory = of(meeting(torch.stack((THREE[0], THREE[1], third))), memory)
        seen.append(bool(memory["exploring"]))
    assert seen == [False, False, True, True, True, False, False, True]


@pytest.mark.parametrize("partner", ["second", "opposing"])
@pytest.mark.parametrize(("length", "conflicting"), [(0.34, True), (0.32, False)])
def test_the_ratio_is_to_the_partner(partner: Any, length: float, conflicting: bool) -> None:
    """λ = 3. The strongest of the others counts in the text; the one that opposes, where that is the partner."""
    stack = torch.tensor([[1.0, 0.0], [-length, 0.0], [0.0, 0.9]], dtype=torch.float64)
    of = rule(partner=partner)
    _, state = of(meeting(stack), exploring_memory(stack, of))
    assert bool(state["exploring"]) == (conflicting and partner == "opposing")


def test_the_dominance_ratio_may_be_of_the_magnitudes() -> None:
    """Lengths of ratio 3.33 have weights of ratio 2.4 with τ = 0.8: only the former exceed λ = 3."""
    gradients = torch.tensor([[1.0, 0.0], [-0.3, 0.0]], dtype=torch.float64)
    for ratio_of, conflicting in (("weights", True), ("magnitudes", False)):
        for partner in ("second", "opposing"):
            of = NullspaceProjection(exploration=Exploration(ratio_of=ratio_of, partner=partner))  # type: ignore[arg-type]
            assert bool(of(meeting(gradients), fresh(of, gradients))[1]["exploring"]) == conflicting


@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_a_ratio_of_magnitudes_does_not_depend_on_their_unit(scale: float) -> None:
    of = NullspaceProjection(exploration=Exploration(ratio_of="magnitudes", partner="opposing"))
    for ratio, conflicting in ((2.99, True), (3.01, False)):
        gradients = scale * pair(-0.9, ratio)
        assert bool(of(meeting(gradients), fresh(of, gradients))[1]["exploring"]) == conflicting


@pytest.mark.parametrize("exploring", [False, True])
@pytest.mark.parametrize(
    "stack",
    [
        torch.tensor([[1.0, 0.0], [0.5, 0.5], [0.2, -0.9]]).double(),
        torch.tensor([[1.0, 0.0], [0.0, 0.0], [0.0, 0.0]]).double(),
        torch.zeros(3, 2).double(),
    ],
    ids=["none opposes", "the others are zero", "all are zero"],
)
def test_where_nothing_opposes_there_is_no_conflict(stack: Tensor, exploring: bool) -> None:
    of = rule(partner="opposing")
    memory = fresh(of, stack) | {"exploring": torch.tensor(exploring)}
    total, state = of(meeting(stack), memory)
    assert not state["exploring"]
    pursuit, _ = NullspaceProjection(temperature=None, margin=0.0, exploration=None)(meeting(stack), memory)
    assert torch.equal(total, pursuit)


@pytest.mark.parametrize("batch", BATCHES, ids=str)
@pytest.mark.parametrize("ratio_of", ["weights", "magnitudes"])
def test_partners_are_found_row_by_row(batch: tuple[int, ...], ratio_of: Any) -> None:
    """Against plain loops, on random stacks of four."""
    stack = normal(*batch, 20, 4, 2, seed=3)
    of = NullspaceProjection(
        exploration=Exploration(-0.3, -0.1, ratio=2.0, partner="opposing", ratio_of=ratio_of), margin=0.0
    )
    before = normal(*batch, 20, seed=8) > 0
    _, state = of(meeting(stack), fresh(of, stack) | {"exploring": before})
    expected = []
    for gradients, exploring in zip(stack.reshape(-1, 4, 2), before.flatten(), strict=True):
        norms = gradients.norm(dim=-1)
        strengths = norms if ratio_of == "magnitudes" else torch.softmax(norms / 0.8, dim=-1)
        first = int(norms.argmax())
        cosines = torch.cosine_similarity(gradients[first], gradients, dim=-1)
        limit = -0.1 if exploring else -0.3
        against = [i for i in range(4) if i != first and cosines[i] <= limit]
        expected.append(bool(against) and bool(strengths[first] <= 2.0 * max(strengths[i] for i in against)))
    assert state["exploring"].flatten().tolist() == expected
    assert 0 < sum(expected) < len(expected)


# --- where to


@pytest.mark.parametrize("batch", BATCHES, ids=str)
@pytest.mark.parametrize("size", [2, 3, 4])
def test_exploration_moves_in_the_nullspace_of_the_dominant_gradient_along_the_average(
    batch: tuple[int, ...], size: int
) -> None:
    gradients = conflict(*batch, size=size)
    average = normal(*batch, size, seed=7)
    total, state = rule()(meeting(gradients), exploring_memory(gradients, rule(), average=average))
    assert state["exploring"].all()
    top = unit(gradients[..., 0, :])
    torch.testing.assert_close((total * top).sum(-1), torch.zeros(batch, dtype=torch.float64), rtol=0, atol=1e-9)
    torch.testing.assert_close(torch.linalg.vector_norm(total, dim=-1), torch.ones(batch, dtype=torch.float64))
    free = state["average"] - (state["average"] * top).sum(-1, keepdim=True) * top
    torch.testing.assert_close(-total, unit(free), rtol=0, atol=1e-4)  # the descent directions count a millionth
    assert ((-total * state["average"]).sum(-1) >= 0).all()


def test_motion_goes_on_in_the_direction_it_came_from() -> None:
    gradients = pair(-0.95)
    for side in (1.0, -1.0):
        average = torch.tensor([0.3, side * 0.1], dtype=torch.float64)
        total, _ = rule()(meeting(gradients), exploring_memory(gradients, rule(), average=average))
        torch.testing.assert_close(-total, torch.tensor([0.0, side], dtype=torch.float64), rtol=0, atol=1e-4)


@pytest.mark.parametrize("time", [0.2, 1.0, 2.0])
@pytest.mark.parametrize("dt", [0.05, 0.5])
def test_the_average_is_an_exponential_moving_one(time: float, dt: float) -> None:
    """m ← m + (motion − m) dt/(dt + T), whether or not a conflict lasts."""
    gradients, motions = pair(0.5), normal(6, 2)
    memory, expected = fresh(rule(), gradients), torch.zeros(2, dtype=torch.float64)
    for motion in motions:
        _, memory = rule(average_time=time)(meeting(gradients, motion=motion, dt=dt), memory)
        expected = expected + (motion - expected) * dt / (dt + time)
        torch.testing.assert_close(memory["average"], expected)


@pytest.mark.parametrize("dtype", DTYPES, ids=str)
@pytest.mark.parametrize("size", [2, 3, 4])
@pytest.mark.parametrize("average", ["none", "along the dominant gradient", "against it"])
@pytest.mark.parametrize("exactly", [True, False], ids=["exactly opposed", "nearly opposed"])
def test_without_an_average_a_direction_in_the_nullspace_is_found(
    dtype: torch.dtype, size: int, average: str, exactly: bool
) -> None:
    """Head on against a wall nothing breaks the symmetry; the motion is still a unit vector in the nullspace."""
    first = normal(5, size, seed=size, dtype=dtype)
    second = -0.9 * first if exactly else -0.9 * first + 1e-3 * normal(5, size, dtype=dtype)
    gradients = torch.stack((first, second), dim=-2)
    scale = {"none": 0.0, "along the dominant gradient": 0.3, "against it": -0.3}[average]
    total, state = rule()(meeting(gradients), exploring_memory(gradients, rule(), average=scale * first))
    assert state["exploring"].all()
    torch.testing.assert_close(torch.linalg.vector_norm(total, dim=-1), torch.ones(5, dtype=dtype))
    assert ((total * unit(first)).sum(-1).abs() < 1e-3).all()


def test_without_an_average_the_descent_directions_decide() -> None:
    """A third gradient, too weak to end the conflict, says which way round."""
    for side in (1.0, -1.0):
        gradients = torch.tensor([[1.0, 0.0], [-0.9, 0.0], [0.0, 0.2 * side]], dtype=torch.float64)
        total, _ = rule()(meeting(gradients), exploring_memory(gradients, rule()))
        torch.testing.assert_close(-total, torch.tensor([0.0, -side], dtype=torch.float64), rtol=0, atol=1e-2)


def test_on_a_line_there_is_nowhere_to_go() -> None:
    gradients = torch.tensor([[1.0], [-0.9]], dtype=torch.float64)
    for escape in (None, Escape(hold="g0"), Escape(hold="g1", along="g1")):
        total, state = rule(escape)(meeting(gradients), fresh(rule(escape), gradients))
        assert state["exploring"]
        assert total.isfinite().all()
    total, _ = rule()(meeting(gradients), fresh(rule(), gradients))
    assert total.tolist() == [0.0]


# --- escape options


def test_the_text_alone_remembers_no_displacement() -> None:
    assert Exploration().escape == Escape() == Escape(progress=None, hold=None, along=None)
    assert "displacement" not in Exploration().initial(2)
    assert "displacement" in Exploration(escape=Escape(progress="g0")).initial(2)


@pytest.mark.parametrize("goal", [0, 1, 2])
def test_along_explores_in_the_nullspace_of_that_goal(goal: int) -> None:
    gradients, average = conflict(4), normal(4, 3, seed=2)
    of = rule(Escape(along=f"g{goal}"))
    total, _ = of(meeting(gradients), exploring_memory(gradients, of, average=average))
    work = (total * unit(gradients[:, goal])).sum(-1)
    torch.testing.assert_close(work, torch.zeros(4, dtype=torch.float64), rtol=0, atol=1e-9)
    torch.testing.assert_close(torch.linalg.vector_norm(total, dim=-1), torch.ones(4, dtype=torch.float64))


def test_along_a_goal_that_does_not_meet_here_is_the_text() -> None:
    gradients = conflict(4)
    first, second = (
        of(meeting(gradients), exploring_memory(gradients, of))[0] for of in (rule(), rule(Escape(along="far")))
    )
    assert torch.equal(first, second)


@pytest.mark.parametrize("gain", [0.5, 3.0])
@pytest.mark.parametrize("strength", [0.1, 0.6, 1.0, 1.4, 1.9, 2.9])
def test_hold_steers_back_to_the_level_where_the_two_balance(gain: float, strength: float) -> None:
    """u = unit(t − k·clip(|∇|/|∇'| − 1, −1, 1)·∇/|∇|), by hand for gradients along one axis."""
    gradients = torch.tensor([[-1.0, 0.0], [strength, 0.0]], dtype=torch.float64)
    of = rule(Escape(hold="g1", hold_gain=gain, along="g1"), ratio=100.0)
    average = torch.tensor([0.0, 1.0], dtype=torch.float64)
    total, _ = of(meeting(gradients), exploring_memory(gradients, of, average=average))
    error = min(max(strength - 1.0, -1.0), 1.0)
    expected = unit(torch.tensor([-gain * error, 1.0], dtype=torch.float64))
    torch.testing.assert_close(-total, expected, rtol=0, atol=1e-5)


def test_hold_keeps_a_noisy_motion_on_the_level() -> None:
    """A point explores around a disc: with feedback it stays where the two balance, without it drifts."""

    def drift(escape: Escape) -> float:
        of = rule(escape, ratio=1e9)
        position = torch.tensor([0.0, 1.1], dtype=torch.float64)  # the level is at distance 1
        memory = exploring_memory(torch.zeros(2, 2, dtype=torch.float64), of)
        memory["average"] = torch.tensor([1.0, 0.0], dtype=torch.float64)
        motion = torch.tensor([0.05, 0.0], dtype=torch.float64)
        for _ in range(200):
            distance = torch.linalg.vector_norm(position)
            away = position / distance
            gradients = torch.stack((away, -torch.exp(4.0 * (1.0 - distance)) * away))  # attracted, repelled
            total, memory = of(meeting(gradients, motion=motion), memory)
            motion = -0.05 * total
            position = position + motion
        return float(torch.linalg.vector_norm(position))

    held = drift(Escape(hold="g1", along="g1"))
    assert held == pytest.approx(1.0, abs=0.02)
    assert drift(Escape(along="g1")) > 1.2


def progress_rule(margin: float = 0.1) -> NullspaceProjection:
    return rule(Escape(progress="far", progress_margin=margin))


def walk(
    of: NullspaceProjection, positions: Tensor, gradients: Callable[[int], Tensor], scale: float = 1.0
) -> list[bool]:
    """Whether it explores along some positions, with the cost ``scale·‖x‖`` of the goal "far"."""
    memory = fresh(of, gradients(0))
    seen, last = [], positions[0]
    for step, position in enumerate(positions):
        _, memory = of(
            meeting(
                gradients(step),
                motion=position - last,
                goals=["far", "near"],
                costs={"far": scale * position.norm(), "near": position.new_zeros(())},
                displaced=lambda goal, shift, at=position: scale * (at + shift).norm(),
            ),
            memory,
        )
        seen.append(bool(memory["exploring"]))
        last = position
    return seen


def test_progress_ends_exploration_only_when_the_goal_is_nearer_than_when_it_began() -> None:
    """The conflict weakens at once, but the way out leads away from the target first."""
    x = torch.tensor([2.0, 2.0, 2.2, 2.5, 2.3, 2.0, 1.95, 1.91, 1.89, 1.5, 1.0], dtype=torch.float64)
    positions = torch.stack((x, torch.zeros_like(x)), dim=-1)

    def gradients(step: int) -> Tensor:
        return pair(-0.9) if step == 0 else pair(0.0)

    with_progress = walk(progress_rule(), positions, gradients)
    assert with_progress == [True] * 8 + [False] * 3  # ends at 1.89 < 2.0 − 0.1
    assert walk(rule(), positions, gradients) == [True] + [False] * 10
    assert walk(progress_rule(margin=0.5), positions, gradients) == [True] * 10 + [False]


def test_progress_alone_does_not_end_a_conflict_that_lasts() -> None:
    positions = torch.stack((torch.linspace(2.0, 0.5, 8), torch.zeros(8)), dim=-1).double()
    assert walk(progress_rule(), positions, lambda step: pair(-0.9)) == [True] * 8


def test_progress_counts_from_each_conflict_anew() -> None:
    x = torch.tensor([2.0, 1.8, 3.0, 2.95, 2.85, 2.5], dtype=torch.float64)
    positions = torch.stack((x, torch.zeros_like(x)), dim=-1)

    def gradients(step: int) -> Tensor:
        return pair(-0.9) if step in (0, 2) else pair(0.0)

    assert walk(progress_rule(), positions, gradients) == [True, False, True, True, False, False]


def test_progress_is_measured_under_the_current_belief() -> None:
    """A stored entry cost would be fooled when the estimate of the cost itself changes."""
    of = progress_rule()
    gradients = pair(0.0)
    motion = torch.tensor([-0.05, 0.0], dtype=torch.float64)
    displacement = torch.tensor([-0.2, 0.0], dtype=torch.float64)

    def step(belief: float) -> bool:
        memory = exploring_memory(gradients, of, displacement=displacement)
        _, memory = of(
            meeting(
                gradients,
                motion=motion,
                goals=["far", "near"],
                costs={"far": torch.tensor(belief, dtype=torch.float64)},
                displaced=lambda goal, shift: (torch.tensor([belief, 0.0], dtype=torch.float64) + shift).norm(),
            ),
            memory,
        )
        torch.testing.assert_close(memory["displacement"], displacement + motion)
        return bool(memory["exploring"])

    assert not step(1.0) and not step(9.0)


def test_paper_literal_has_none_of_the_escapes() -> None:
    literal: Any = make_policy("nav2d", preset="paper_literal")
    assert literal.resolution.exploration.escape == Escape()
    assert literal.law.accumulate
    assert (literal.resolution.exploration.enter_cosine, literal.resolution.exploration.exit_cosine) == (-0.6, -0.4)
    assert (literal.resolution.exploration.ratio, literal.resolution.temperature) == (3.0, 0.8)
    assert literal.resolution.margin == 0.1
    ours: Any = make_policy("nav2d")
    assert (ours.resolution.exploration.escape.progress, ours.resolution.exploration.escape.hold) == ("reach", "avoid")
    for preset, field in (
        ("no_progress_exit", "progress"),
        ("no_level_hold", "hold"),
        ("no_obstacle_nullspace", "along"),
    ):
        escape = make_policy("nav2d", preset=preset).resolution.exploration.escape  # type: ignore[union-attr]
        assert getattr(escape, field) is None
        assert sum(getattr(escape, other) is None for other in ("progress", "hold", "along")) == 1


def test_an_escape_acts_through_a_gradient_that_arrives_merged_with_others() -> None:
    """A goal that joined another on the way acts as their sum; one that comes several ways as the sum of these."""
    gradients, average = conflict(4), normal(4, 3, seed=2)
    for names, rows in ((["g0", "g1+other", "g2"], [1]), (["g0", "g1", "g1"], [1, 2])):
        of = rule(Escape(along="g1"))
        total, _ = of(meeting(gradients, goals=names), exploring_memory(gradients, of, average=average))
        normal_to = unit(gradients[:, rows].sum(-2))
        torch.testing.assert_close((total * normal_to).sum(-1), torch.zeros(4).double(), rtol=0, atol=1e-9)
        alone = rule(Escape(hold="g1", along="g1"), ratio=100.0)
        held, _ = alone(meeting(gradients, goals=names), exploring_memory(gradients, alone, average=average))
        assert ((held * normal_to).sum(-1).abs() > 1e-3).all()


@pytest.mark.parametrize("escape", [Escape(progress="far"), Escape(hold="far"), Escape(along="far")])
def test_an_escape_by_a_goal_that_is_not_concerned_here_is_the_text(escape: Escape) -> None:
    """Else a conflict at one quantity would wait for ever for progress at another."""
    for cosine, before in ((-0.9, False), (-0.5, True), (-0.3, True)):
        gradients = pair(cosine)
        memory = exploring_memory(gradients, rule(escape)) | {"exploring": torch.tensor(before)}
        costs = {"far": torch.tensor(1.0).double()}
        got, state = rule(escape)(meeting(gradients, costs=costs), memory)
        expected, text = rule()(meeting(gradients), memory)
        assert torch.equal(got, expected) and torch.equal(state["exploring"], text["exploring"])


# --- in a graph


def two_arms() -> WorldModel:
    """Two independent quantities; the sensor places the conflict in one of them, in both or in none."""

    def left(a: Tensor) -> Tensor:
        return a

    def right(b: Tensor) -> Tensor:
        return b

    def toward_left(left: Tensor) -> Tensor:
        return left[..., 0]

    def against_left(left: Tensor, z: Tensor) -> Tensor:
        return -0.9 * z[..., 0] * left[..., 0] + (1 - z[..., 0]) * left[..., 1]

    def toward_right(right: Tensor) -> Tensor:
        return right[..., 0]

    def against_right(right: Tensor, z: Tensor) -> Tensor:
        return -0.9 * z[..., 1] * right[..., 0] + (1 - z[..., 1]) * right[..., 1]

    return WorldModel(
        sensors={"z": Sensor(2, "1")},
        actuators={"a": Actuator(2, "m"), "b": Actuator(2, "m")},
        estimators=[Deterministic("left", left), Deterministic("right", right)],
        goals=[Goal(f.__name__, f) for f in (toward_left, against_left, toward_right, against_right)],
        dtype=torch.float64,
    )


def test_memory_is_of_each_quantity() -> None:
    policy = Policy(two_arms(), rule(), ActionLaw(1.0, smoothing=0.0))
    conflicts = [(0, 0), (1, 0), (1, 1), (0, 1), (0, 0)]
    memories = rollout(policy, [{"z": torch.tensor(c, dtype=torch.float64)} for c in conflicts])
    seen = [(int(memory["left/exploring"]), int(memory["right/exploring"])) for memory in memories]
    assert seen == conflicts
    for name in ("rank", "cosine", "average", "exploring", "gradients"):
        assert f"left/{name}" in memories[0] and f"right/{name}" in memories[0]


def test_an_escape_that_names_no_goal_of_the_model_is_an_error() -> None:
    for escape in (Escape(progress="reech"), Escape(hold="reech"), Escape(along="reech")):
        with pytest.raises(OptionError, match=r"'reech'.*'toward_left'"):
            Policy(two_arms(), rule(escape), ActionLaw(1.0))


@pytest.mark.parametrize(
    ("options", "culprit"),
    [
        ({"enter_cosine": -0.3}, "enter_cosine=-0.3"),
        ({"enter_cosine": -1.1}, "enter_cosine"),
        ({"exit_cosine": 1.1}, "exit_cosine"),
        ({"exit_cosine": math.nan}, "exit_cosine"),
        ({"ratio": 0.9}, "ratio"),
        ({"average_time": 0.0}, "average_time"),
        ({"partner": "third"}, "partner='third'.*'second' or 'opposing'"),
        ({"ratio_of": "costs"}, "ratio_of='costs'.*'weights' or 'magnitudes'"),
    ],
)
def test_bad_options_are_named(options: dict[str, Any], culprit: str) -> None:
    with pytest.raises(OptionError, match=culprit):
        Exploration(**options)
