"""The backward pass with projection and exploration on random graphs.

What never matters, and what holds always.
"""

from collections import Counter
from random import Random

import torch
from _asserts import assert_rows_stand_alone, rollout
from _inputs import Blueprint, built, graphs, readings
from hypothesis import given
from hypothesis import strategies as st

from aicon_torch import DirectDescent, Exploration, NullspaceProjection, Policy, WorldModel


def eager(model: WorldModel, by_row: bool = True) -> Policy:
    """The shipped rule, which explores at the slightest conflict, so that there is much of it."""
    exploration = Exploration(enter_cosine=-0.1, exit_cosine=0.0, ratio=10.0)
    rule = NullspaceProjection(by_row=by_row, exploration=exploration)
    return Policy(model, rule, DirectDescent(gain=0.5))


@given(graphs())
def test_singles_are_rows_of_a_batch(blueprint: Blueprint) -> None:
    recorded = [readings((3,), seed) for seed in range(3)]
    assert_rows_stand_alone(eager(built(blueprint)), recorded, rows=(0, 2))


@given(graphs(), st.randoms(use_true_random=False))
def test_order_of_the_goals_does_not_matter(blueprint: Blueprint, random: Random) -> None:
    model = built(blueprint)
    names = list(model.goals)
    random.shuffle(names)
    shuffled = blueprint.build(goals=names)

    recorded = [readings((), seed) for seed in range(4)]
    memories = rollout(eager(model), recorded)
    others = rollout(eager(shuffled), recorded)

    for memory, other in zip(memories, others, strict=True):
        for actuator in model.actuators:
            torch.testing.assert_close(memory[actuator], other[actuator], rtol=1e-9, atol=1e-12)


@given(graphs())
def test_gradients_are_finite_and_meet_where_the_memory_says(blueprint: Blueprint) -> None:
    model = built(blueprint)
    recorded = [readings((2,), seed) for seed in range(3)]
    memory = rollout(eager(model, by_row=False), recorded)[-1]
    assert all(value.isfinite().all() for value in memory.values())

    arriving: Counter[str] = Counter()
    for edges in model.edges.values():
        for edge in edges:
            arriving[edge.source] += len(edge.labels)

    suffix = "/gradients"
    remembered = {key.removesuffix(suffix) for key in memory if key.endswith(suffix)}
    assert remembered == {quantity for quantity, count in arriving.items() if count > 1}
