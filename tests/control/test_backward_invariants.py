"""The backward pass with projection and exploration on random graphs.

What never matters, and what holds always.
"""

from typing import Any

import torch
from _asserts import assert_rows_stand_alone, rollout
from _inputs import Blueprint, built, graphs, readings
from hypothesis import given
from hypothesis import strategies as st

from aicon_torch import ActionLaw, Exploration, NullspaceProjection, Policy


def full_rule() -> NullspaceProjection:
    """Projection, ordering with hysteresis, and exploration at the slightest conflict, so that
    there is much of it.
    """
    return NullspaceProjection(
        exploration=Exploration(enter_cosine=-0.1, exit_cosine=0.0, ratio=10.0)
    )


@given(graphs())
def test_singles_are_rows_of_a_batch(blueprint: Blueprint) -> None:
    model = built(blueprint)
    policy = Policy(model, full_rule(), ActionLaw(gain=0.5))
    assert_rows_stand_alone(policy, [readings((3,), seed) for seed in range(3)], rows=(0, 2))


@given(graphs(), st.randoms(use_true_random=False))
def test_order_of_the_goals_does_not_matter(blueprint: Blueprint, random: Any) -> None:
    model = built(blueprint)
    names = list(model.goals)
    random.shuffle(names)
    other = blueprint.build(goals=names)
    recorded = [readings((), seed) for seed in range(4)]

    for first, second in zip(
        rollout(Policy(model, full_rule(), ActionLaw(0.5)), recorded),
        rollout(Policy(other, full_rule(), ActionLaw(0.5)), recorded),
        strict=True,
    ):
        for actuator in model.actuators:
            torch.testing.assert_close(first[actuator], second[actuator], rtol=1e-9, atol=1e-12)


@given(graphs())
def test_gradients_are_finite_and_meet_where_the_memory_says(blueprint: Blueprint) -> None:
    model = built(blueprint)
    policy = Policy(model, full_rule(), ActionLaw(gain=0.5))
    memory = rollout(policy, [readings((2,), seed) for seed in range(3)])[-1]

    assert all(value.isfinite().all() for value in memory.values())

    readers: dict[str, int] = {}
    for edges in model.edges.values():
        for edge in edges:
            readers[edge.source] = readers.get(edge.source, 0) + len(edge.labels)

    assert {key.split("/")[0] for key in memory if key.endswith("/gradients")} == {
        q for q, n in readers.items() if n > 1
    }
