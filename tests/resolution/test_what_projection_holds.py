"""What a projection holds against several pulls, and what a sum does: docs/research/projection.md.

Goals of bounded slope in the plane, one gradient a step, without softmax and exploration.
"""

import math
from collections.abc import Callable

import pytest
import torch
from _inputs import fresh, gradient_stack, unweighted
from torch import Tensor

from aicon_torch import Resolution, SteepestPath, Sum

STEP, STEPS = 0.0025, 200
RULES: dict[str, Callable[[], Resolution]] = {
    "sum": Sum,
    "projection": unweighted,
    "steepest": SteepestPath,
}


def descend(name: str, gradients: Callable[[Tensor], list[list[float]]]) -> Tensor:
    """Where a point that began at the origin is after some steps of a rule."""
    rule, point = RULES[name](), torch.zeros(2, dtype=torch.float64)
    memory = fresh(rule, torch.tensor(gradients(point), dtype=torch.float64))

    for _ in range(STEPS):
        stack = torch.tensor(gradients(point), dtype=torch.float64)
        resolved, memory = rule(gradient_stack(stack), memory)
        point = point - STEP * resolved
    return point


def sinks(name: str, slope: float, angles: list[float]) -> bool:
    """Whether pulls of slope 1, turned from straight down by angles, take a point through a floor.

    Below the floor, y < 0, its own gradient is (0, −slope).
    """
    pulls = [[-math.sin(angle), math.cos(angle)] for angle in angles]

    def gradients(point: Tensor) -> list[list[float]]:
        return [[0.0, -slope if point[1] < 0 else 0.0], *pulls]

    return bool(descend(name, gradients)[1] < -0.05)


@pytest.mark.parametrize("name", RULES)
@pytest.mark.parametrize("slope", [0.5, 0.8, 1.2, 3.0])
def test_against_one_pull_all_rules_hold_alike(name: str, slope: float) -> None:
    assert sinks(name, slope, [0.0]) == (slope < 1.0)


@pytest.mark.parametrize("count", [2, 3, 6])
@pytest.mark.parametrize("lean", [0.0, 0.5])
def test_a_sum_holds_against_the_sum_of_the_pulls_and_a_projection_against_the_largest(
    count: int, lean: float
) -> None:
    angles = [lean * (-1) ** index for index in range(count)]
    downward = count * math.cos(lean)
    assert sinks("sum", 0.8 * downward, angles)
    assert not sinks("sum", 1.2 * downward, angles)

    assert not sinks("projection", 1.15, angles)  # the margin of the ranks is 10 %
    assert sinks("projection", 0.8, angles)


def test_a_weaker_goal_is_served_beside_a_stronger_one_but_not_by_the_steepest_path() -> None:
    """It leans against the stronger goal by 51°, as far as it goes along it is served."""
    angle = math.radians(51.0)

    def gradients(point: Tensor) -> list[list[float]]:
        return [[0.0, -2.0], [math.sin(angle), math.cos(angle)]]

    served = {name: float(-descend(name, gradients)[0]) for name in RULES}
    assert served["projection"] == pytest.approx(STEPS * STEP * math.sin(angle))
    assert served["sum"] == pytest.approx(served["projection"])
    assert served["steepest"] == 0.0


def test_among_two_slopes_that_grow_projection_rests_where_the_sum_rests() -> None:
    """Costs x²/2 and (x − 1)²/2 · 3 along a line: g₁′ = −g₂′ at x = 3/4."""

    def gradients(point: Tensor) -> list[list[float]]:
        x = float(point[0])
        return [[4 * x, 0.0], [12 * (x - 1.0), 0.0]]

    for name in RULES:
        assert float(descend(name, gradients)[0]) == pytest.approx(0.75, abs=0.02)
