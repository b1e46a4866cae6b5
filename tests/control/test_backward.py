"""The backward pass on random graphs.

Its sum is the total derivative, and paths are what Eq. 1 says.
"""

import itertools
from typing import Any

import torch
from _asserts import (
    along,
    assert_equal_gradients,
    numeric_totals,
    sums_over_paths,
    through_jacobians,
    totals,
)
from _inputs import (
    Blueprint,
    actions,
    blueprints,
    built,
    graphs,
    in_motion,
    readings,
    unlimited,
)
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from torch import Tensor

from aicon_torch import Policy, SteepestPath, Sum, WorldModel

MANY = 300
"""Paths beyond which a random graph is left out, to save time."""


def enumerable(blueprint: Blueprint) -> WorldModel:
    """The model, if its paths are few enough to walk."""
    model = built(blueprint)
    assume(len(model.paths()) <= MANY)
    return model


def stepped(
    model: WorldModel, batch: tuple[int, ...]
) -> tuple[dict[str, Tensor], dict[str, Tensor], Any]:
    """Values after one more step, the actions that led there, and the local of the step."""
    moved = actions(model, batch, 9)
    values, local = model.step(in_motion(model, batch) | moved | readings(batch, 9))
    return values, moved, local


def descended(policy: Policy, model: WorldModel, batch: tuple[int, ...]) -> dict[str, Tensor]:
    """The gradients that a policy descends at the same values as :func:`stepped`."""
    _, memory = policy.predict(readings(batch, 1))
    memory |= in_motion(model, batch) | actions(model, batch, 9)
    _, memory = policy.predict(readings(batch, 9), memory)
    return {name: -memory[name] for name in model.actuators}


@given(graphs(), st.sampled_from([(), (1,), (2, 3)]))
def test_sum_over_paths_is_the_sweep_is_the_total_derivative(
    blueprint: Blueprint, batch: tuple[int, ...]
) -> None:
    model = enumerable(blueprint)
    values, moved, local = stepped(model, batch)
    total = totals(model, values, moved)
    assert_equal_gradients(sums_over_paths(model, local), total)
    assert_equal_gradients(descended(unlimited(model, Sum()), model, batch), total)


@given(graphs())
def test_factors_of_a_path_are_full_jacobians(blueprint: Blueprint) -> None:
    model = enumerable(blueprint)
    _, _, local = stepped(model, ())

    for path in itertools.islice(model.paths(), 30):
        torch.testing.assert_close(
            along(path, model, local), through_jacobians(path, model, local), rtol=1e-10, atol=1e-12
        )


@given(graphs(derivatives=("model", "update")))
def test_total_derivative_agrees_with_finite_differences(blueprint: Blueprint) -> None:
    model = enumerable(blueprint)
    values, moved, _ = stepped(model, ())
    assert_equal_gradients(
        totals(model, values, moved), numeric_totals(model, values, moved), rtol=1e-6
    )


@given(graphs(), st.sampled_from([(), (3,)]))
def test_steepest_path_is_the_longest_of_all_path_gradients(
    blueprint: Blueprint, batch: tuple[int, ...]
) -> None:
    model = enumerable(blueprint)
    assume(len(model.paths()) <= 60)
    _, _, local = stepped(model, batch)
    steepest = descended(unlimited(model, SteepestPath()), model, batch)

    for actuator in model.actuators:
        stack = torch.stack(
            [along(p, model, local) for p in model.paths() if p.actuator == actuator], dim=-2
        )
        longest = stack.norm(dim=-1).argmax(-1, keepdim=True)
        expected = stack.take_along_dim(longest.unsqueeze(-1), -2).squeeze(-2)
        torch.testing.assert_close(steepest[actuator], expected, rtol=1e-9, atol=1e-12)


@given(graphs())
def test_number_of_paths_is_counted_without_walking_them(blueprint: Blueprint) -> None:
    model = enumerable(blueprint)
    paths = list(model.paths())

    assert len(model.paths()) == len(paths) == len(set(paths))

    for path in paths:
        assert path.goal in model.goals and path.actuator in model.actuators
        assert len(set(path.quantities)) == len(path.quantities)


@settings(max_examples=10)
@given(blueprints())
def test_a_factor_scales_the_gradient_of_its_goal(blueprint: Blueprint) -> None:
    model = enumerable(blueprint)
    policy = unlimited(model, Sum())
    _, memory = policy.predict(readings((), 0))
    whole, _ = policy.predict(readings((), 1), memory)
    parts = []

    for name in model.goals:
        others = {goal: goal == name for goal in model.goals}
        parts.append(policy.predict(readings((), 1), policy.switch(memory, **others))[0])

    for actuator in model.actuators:
        pick = (
            (lambda action, a=actuator: action[a])
            if len(model.actuators) > 1
            else (lambda action: action)
        )
        torch.testing.assert_close(
            pick(whole), sum(pick(part) for part in parts), rtol=1e-9, atol=1e-12
        )
