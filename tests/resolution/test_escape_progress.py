"""Progress: exploration ends only when a goal is nearer than when it began."""

from collections.abc import Sequence

import torch
from _inputs import exploring_memory, fresh, literal, pair, resolve
from torch import Tensor

from aicon_torch import NullspaceProjection, TrapEscape


def progress_rule(margin: float = 0.1) -> NullspaceProjection:
    return literal(TrapEscape(progress="far", progress_margin=margin))


def walk(
    rule: NullspaceProjection, distances: Sequence[float], conflicts: Sequence[int]
) -> list[bool]:
    """Whether it explores at some distances from the goal "far", whose cost is the distance.

    The gradients oppose each other at the steps that are named as conflicts, and only there.
    """
    memory, last = fresh(rule, pair(0.0)), distances[0]
    exploring: list[bool] = []

    for step, distance in enumerate(distances):
        here = torch.tensor([distance, 0.0], dtype=torch.float64)
        motion = torch.tensor([distance - last, 0.0], dtype=torch.float64)

        def displaced_cost(goal: str, shift: Tensor, here: Tensor = here) -> Tensor:
            return (here + shift).norm()

        _, memory = resolve(
            rule,
            pair(-0.9) if step in conflicts else pair(0.0),
            memory,
            motion=motion,
            goals=["far", "near"],
            costs={"far": here.norm(), "near": torch.zeros_like(here[0])},
            displaced_cost=displaced_cost,
        )
        exploring.append(bool(memory["exploring"]))
        last = distance

    return exploring


def test_progress_ends_exploration_only_when_the_goal_is_nearer_than_when_it_began() -> None:
    """The conflict weakens at once, but the way out leads away from the target first."""
    distances = [2.0, 2.0, 2.2, 2.5, 2.3, 2.0, 1.95, 1.91, 1.89, 1.5, 1.0]

    # It ends at 1.89 < 2.0 − 0.1.
    assert walk(progress_rule(), distances, conflicts=[0]) == [True] * 8 + [False] * 3
    assert walk(progress_rule(margin=0.5), distances, conflicts=[0]) == [True] * 10 + [False]
    assert walk(literal(), distances, conflicts=[0]) == [True] + [False] * 10


def test_progress_alone_does_not_end_a_conflict_that_lasts() -> None:
    distances = torch.linspace(2.0, 0.5, 8).tolist()
    assert walk(progress_rule(), distances, conflicts=range(8)) == [True] * 8


def test_progress_counts_from_each_conflict_anew() -> None:
    distances = [2.0, 1.8, 3.0, 2.95, 2.85, 2.5]
    expected = [True, False, True, True, False, False]
    assert walk(progress_rule(), distances, conflicts=[0, 2]) == expected


def test_progress_is_measured_under_the_current_belief() -> None:
    """A stored entry cost would be fooled when the estimate of the cost itself changes."""
    rule, gradients = progress_rule(), pair(0.0)
    motion = torch.tensor([-0.05, 0.0], dtype=torch.float64)
    displacement = torch.tensor([-0.2, 0.0], dtype=torch.float64)

    for belief in (1.0, 9.0):
        here = torch.tensor([belief, 0.0], dtype=torch.float64)

        def displaced_cost(goal: str, shift: Tensor, here: Tensor = here) -> Tensor:
            return (here + shift).norm()

        _, memory = resolve(
            rule,
            gradients,
            exploring_memory(gradients, rule, displacement=displacement),
            motion=motion,
            goals=["far", "near"],
            costs={"far": here.norm()},
            displaced_cost=displaced_cost,
        )
        torch.testing.assert_close(memory["displacement"], displacement + motion)
        assert not memory["exploring"]
