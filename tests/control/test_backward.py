"""The backward pass on random graphs.

Its sum is the total derivative, and paths are what Eq. 1 says.
"""

import itertools

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
    remembered,
    unlimited,
)
from hypothesis import assume, given
from hypothesis import strategies as st
from torch import Tensor

from aicon_torch import Policy, SteepestPath, Sum, WorldModel
from aicon_torch.graph import LocalGraphs

MANY = 300
"""Paths beyond which a random graph is left out, to save time."""


def enumerable(blueprint: Blueprint, most: int = MANY) -> WorldModel:
    """The model, if its paths are few enough to walk."""
    model = built(blueprint)
    assume(len(model.paths()) <= most)
    return model


def stepped(
    model: WorldModel, batch: tuple[int, ...]
) -> tuple[dict[str, Tensor], dict[str, Tensor], LocalGraphs]:
    """Values after one more step, the actions that led there, and the local graphs of the step."""
    moved = actions(model, batch, 9)
    values = model.update(in_motion(model, batch) | moved | readings(batch, 9))
    return values, moved, model.record(values)


def descended(policy: Policy, batch: tuple[int, ...]) -> dict[str, Tensor]:
    """The gradients that a policy descends at the same values as :func:`stepped`."""
    model = policy.model
    _, memory = policy.predict(readings(batch, 1))
    memory |= remembered(model, in_motion(model, batch)) | actions(model, batch, 9)

    _, memory = policy.predict(readings(batch, 9), memory)
    return {name: -memory[name] for name in model.actuators}


# --- along each path


@given(graphs())
def test_factors_of_a_path_are_full_jacobians(blueprint: Blueprint) -> None:
    model = enumerable(blueprint)
    _, _, local = stepped(model, ())

    for path in itertools.islice(model.paths(), 30):
        gradient, expected = along(path, model, local), through_jacobians(path, model, local)
        torch.testing.assert_close(gradient, expected, rtol=1e-10, atol=1e-12)


@given(graphs())
def test_number_of_paths_is_counted_without_walking_them(blueprint: Blueprint) -> None:
    model = enumerable(blueprint)
    paths = list(model.paths())
    assert len(model.paths()) == len(paths) == len(set(paths))

    for path in paths:
        assert path.goal in model.goals and path.actuator in model.actuators
        assert len(set(path.quantities)) == len(path.quantities)


@given(graphs(), st.sampled_from([(), (3,)]))
def test_steepest_path_is_the_longest_of_all_path_gradients(
    blueprint: Blueprint, batch: tuple[int, ...]
) -> None:
    model = enumerable(blueprint, most=60)
    _, _, local = stepped(model, batch)
    steepest = descended(unlimited(model, SteepestPath()), batch)

    for actuator in model.actuators:
        paths = [path for path in model.paths() if path.actuator == actuator]
        stack = torch.stack([along(path, model, local) for path in paths], dim=-2)

        longest = stack.norm(dim=-1).argmax(-1)[..., None, None]
        expected = stack.take_along_dim(longest, -2).squeeze(-2)
        torch.testing.assert_close(steepest[actuator], expected, rtol=1e-9, atol=1e-12)


# --- their sum


@given(graphs(), st.sampled_from([(), (1,), (2, 3)]))
def test_sum_over_paths_is_the_backward_pass_is_the_total_derivative(
    blueprint: Blueprint, batch: tuple[int, ...]
) -> None:
    model = enumerable(blueprint)
    values, moved, local = stepped(model, batch)
    total = totals(model, values, moved)

    assert_equal_gradients(sums_over_paths(model, local), total)
    assert_equal_gradients(descended(unlimited(model, Sum()), batch), total)


@given(graphs(derivatives=("model", "update")))
def test_total_derivative_agrees_with_finite_differences(blueprint: Blueprint) -> None:
    model = enumerable(blueprint)
    values, moved, _ = stepped(model, ())

    total, expected = totals(model, values, moved), numeric_totals(model, values, moved)
    assert_equal_gradients(total, expected, rtol=1e-6)


@given(blueprints())
def test_a_factor_scales_the_gradient_of_its_goal(blueprint: Blueprint) -> None:
    model = enumerable(blueprint)
    policy = unlimited(model, Sum())
    _, memory = policy.predict(readings((), 0))
    _, whole = policy.predict(readings((), 1), memory)

    sums = {name: torch.zeros_like(whole[name]) for name in model.actuators}
    for name in model.goals:
        alone = {goal: goal == name for goal in model.goals}
        _, after = policy.predict(readings((), 1), policy.switch(memory, **alone))
        sums = {actuator: total + after[actuator] for actuator, total in sums.items()}

    for actuator, total in sums.items():
        torch.testing.assert_close(whole[actuator], total, rtol=1e-9, atol=1e-12)
