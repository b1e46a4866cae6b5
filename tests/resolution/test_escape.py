"""What an escape adds to the text: a nullspace of choice, and a level that is held."""

from typing import Any

import pytest
import torch
from _inputs import (
    conflict,
    direction,
    exploration_in_paper,
    exploring_memory,
    lengths,
    literal,
    normal,
    pair,
    resolve,
)
from torch import Tensor

from aicon_torch import TrapEscape, make_policy
from aicon_torch.resolution.exploration import turned_with

NONE = torch.zeros(4, dtype=torch.float64)
ONES = torch.ones(4, dtype=torch.float64)


def test_the_text_alone_remembers_no_displacement() -> None:
    text, progress = exploration_in_paper(), exploration_in_paper(escape=TrapEscape(progress="g0"))

    assert text.escape == TrapEscape() == TrapEscape(progress=None, hold=None, along=None)
    assert "displacement" not in text.initial(2)
    assert "displacement" in progress.initial(2)


def test_paper_literal_has_none_of_the_escapes() -> None:
    literal: Any = make_policy("nav2d", preset="paper_literal")
    assert literal.law.accumulate
    assert (literal.resolution.temperature, literal.resolution.margin) == (0.8, 0.1)

    exploration = literal.resolution.exploration
    assert exploration.escape == TrapEscape()
    assert (exploration.enter_cosine, exploration.exit_cosine) == (-0.6, -0.4)
    assert exploration.ratio == 3.0

    ours: Any = make_policy("nav2d")
    escape = ours.resolution.exploration.escape
    assert (escape.progress, escape.hold) == ("reach", "avoid")


# --- a side that is kept


def unit_at(degrees: float) -> Tensor:
    angle = torch.tensor(degrees, dtype=torch.float64).deg2rad()
    return torch.stack((angle.cos(), angle.sin()))


@pytest.mark.parametrize("turn", [-110, -90, -20, 0, 45, 90, 110])
def test_onward_a_direction_turns_with_its_normal_and_keeps_its_side(turn: float) -> None:
    for side in (-90, 90):
        onward = turned_with(unit_at(30 + side), unit_at(30), unit_at(30 + turn))
        torch.testing.assert_close(onward, unit_at(30 + turn + side))


def test_onward_a_direction_stays_between_two_walls() -> None:
    along = unit_at(90)
    torch.testing.assert_close(turned_with(along, unit_at(0), unit_at(180)), along)


def test_onward_an_inner_corner_is_no_end() -> None:
    """The average points into the corner; what it did last, and its normal, lead out of it."""
    gradients, into_the_corner = conflict(4), normal(4, 3, seed=2)
    rule = literal(TrapEscape(along="g0", onward=True))
    memory = exploring_memory(gradients, rule, average=into_the_corner)
    wall = direction(gradients[:, 0])
    tangent = torch.linalg.cross(wall, normal(4, 3, seed=3))
    tangent = tangent / lengths(tangent).unsqueeze(-1)
    total, after = resolve(rule, gradients, {**memory, "tangent": tangent, "normal": wall})

    torch.testing.assert_close(-total, tangent, rtol=0, atol=1e-5)
    torch.testing.assert_close(after["tangent"], tangent, rtol=0, atol=1e-5)


# --- a nullspace of choice


@pytest.mark.parametrize("goal", [0, 1, 2])
def test_along_explores_in_the_nullspace_of_that_goal(goal: int) -> None:
    gradients, average = conflict(4), normal(4, 3, seed=2)
    rule = literal(TrapEscape(along=f"g{goal}"))
    total, _ = resolve(rule, gradients, exploring_memory(gradients, rule, average=average))

    work = (total * direction(gradients[:, goal])).sum(-1)
    torch.testing.assert_close(work, NONE, rtol=0, atol=1e-9)
    torch.testing.assert_close(lengths(total), ONES)


def test_along_several_explores_in_their_common_nullspace() -> None:
    gradients, average = conflict(4), normal(4, 3, seed=2)
    rule = literal(TrapEscape(along=("g0", "g2")))
    total, _ = resolve(rule, gradients, exploring_memory(gradients, rule, average=average))

    for goal in (0, 2):
        work = (total * direction(gradients[:, goal])).sum(-1)
        torch.testing.assert_close(work, NONE, rtol=0, atol=1e-9)
    torch.testing.assert_close(lengths(total), ONES)


def test_several_goals_are_named_one_by_one() -> None:
    escape = TrapEscape(progress="g0", hold=("g1", "g2"), along="g1")
    assert escape.goals == ("g0", "g1", "g2", "g1")


def test_along_a_goal_that_does_not_meet_here_is_the_text() -> None:
    gradients = conflict(4)
    text, far = literal(), literal(TrapEscape(along="far"))

    expected, _ = resolve(text, gradients, exploring_memory(gradients, text))
    total, _ = resolve(far, gradients, exploring_memory(gradients, far))
    assert torch.equal(total, expected)


# --- a level that is held


@pytest.mark.parametrize("gain", [0.5, 3.0])
@pytest.mark.parametrize("strength", [0.1, 0.6, 1.0, 1.4, 1.9, 2.9])
def test_hold_steers_back_to_the_level_where_the_two_balance(gain: float, strength: float) -> None:
    """u = unit(t − k·clip(|∇|/|∇'| − 1, −1, 1)·∇/|∇|), by hand for gradients along one axis."""
    gradients = torch.tensor([[-1.0, 0.0], [strength, 0.0]], dtype=torch.float64)
    rule = literal(TrapEscape(hold="g1", hold_gain=gain, along="g1"), ratio=100.0)

    average = torch.tensor([0.0, 1.0], dtype=torch.float64)
    total, _ = resolve(rule, gradients, exploring_memory(gradients, rule, average=average))

    error = min(max(strength - 1.0, -1.0), 1.0)
    expected = direction(torch.tensor([-gain * error, 1.0], dtype=torch.float64))
    torch.testing.assert_close(-total, expected, rtol=0, atol=1e-5)


def around_a_disc(position: Tensor) -> Tensor:
    """One gradient attracts to the disc, one repels from it; they balance at distance 1."""
    distance = torch.linalg.vector_norm(position)
    away = position / distance
    return torch.stack((away, -torch.exp(4.0 * (1.0 - distance)) * away))


def distance_after_exploring(escape: TrapEscape) -> float:
    """How far from the disc a point is that has explored around it for a while."""
    rule = literal(escape, ratio=1e9)
    position = torch.tensor([0.0, 1.1], dtype=torch.float64)
    motion = torch.tensor([0.05, 0.0], dtype=torch.float64)
    memory = exploring_memory(around_a_disc(position), rule, average=20.0 * motion)

    for _ in range(200):
        total, memory = resolve(rule, around_a_disc(position), memory, motion=motion)
        motion = -0.05 * total
        position = position + motion

    return float(torch.linalg.vector_norm(position))


def test_hold_keeps_a_noisy_motion_on_the_level() -> None:
    """With feedback the point stays where the two balance, without it drifts."""
    held = distance_after_exploring(TrapEscape(hold="g1", along="g1"))
    assert held == pytest.approx(1.0, abs=0.02)
    assert distance_after_exploring(TrapEscape(along="g1")) > 1.2


# --- in a graph, where gradients arrive merged, several times, or not at all


@pytest.mark.parametrize(
    ("names", "rows"), [(["g0", "g1+other", "g2"], [1]), (["g0", "g1", "g1"], [1, 2])], ids=str
)
def test_an_escape_acts_through_a_gradient_that_arrives_merged_with_others(
    names: list[str], rows: list[int]
) -> None:
    """A goal that joined another on the way acts as their sum.

    One that comes several ways acts as the sum of these.
    """
    gradients, average = conflict(4), normal(4, 3, seed=2)
    arrived = direction(gradients[:, rows].sum(-2))

    along = literal(TrapEscape(along="g1"))
    memory = exploring_memory(gradients, along, average=average)
    total, _ = resolve(along, gradients, memory, goals=names)
    torch.testing.assert_close((total * arrived).sum(-1), NONE, rtol=0, atol=1e-9)

    hold = literal(TrapEscape(hold="g1", along="g1"), ratio=100.0)
    memory = exploring_memory(gradients, hold, average=average)
    held, _ = resolve(hold, gradients, memory, goals=names)
    assert ((held * arrived).sum(-1).abs() > 1e-3).all()


@pytest.mark.parametrize("field", ["progress", "hold", "along"])
@pytest.mark.parametrize(("cosine", "before"), [(-0.9, False), (-0.5, True), (-0.3, True)])
def test_an_escape_by_a_goal_that_is_not_concerned_here_is_the_text(
    field: str, cosine: float, before: bool
) -> None:
    """Else a conflict at one quantity would wait for ever for progress at another."""
    gradients, rule = pair(cosine), literal(TrapEscape(**{field: "far"}))
    memory = exploring_memory(gradients, rule) | {"exploring": torch.tensor(before)}

    costs = {"far": torch.tensor(1.0, dtype=torch.float64)}
    total, state = resolve(rule, gradients, memory, costs=costs)

    expected, text = resolve(literal(), gradients, memory)
    assert torch.equal(total, expected)
    assert torch.equal(state["exploring"], text["exploring"])
