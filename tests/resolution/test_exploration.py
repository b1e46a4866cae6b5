"""Exploration: when a conflict begins and ends."""

import math
from typing import Any

import pytest
import torch
from _asserts import rollout
from _inputs import (
    DTYPES,
    SCENARIOS,
    explores,
    fresh,
    gradient_stack,
    literal,
    pair,
    projection_in_paper,
    pursuit,
    resolve,
)
from torch import Tensor

from aicon_torch import (
    Actuator,
    Deterministic,
    DirectDescent,
    Exploration,
    Goal,
    NullspaceProjection,
    OptionError,
    Policy,
    Sensor,
    TrapEscape,
    WorldModel,
)


@pytest.mark.parametrize(("before", "cosine", "ratio", "after"), SCENARIOS)
@pytest.mark.parametrize("dtype", DTYPES, ids=str)
def test_a_conflict_begins_and_ends(
    before: bool, cosine: float, ratio: float, after: bool, dtype: torch.dtype
) -> None:
    gradients = pair(cosine, ratio, dtype)
    memory = fresh(literal(), gradients) | {"exploring": torch.tensor(before)}

    total, state = resolve(literal(), gradients, memory)
    assert bool(state["exploring"]) == after
    assert float(state["cosine"]) == pytest.approx(cosine, abs=1e-6)

    downhill, _ = resolve(pursuit(), gradients, memory)
    assert torch.equal(total, downhill) != after


def test_rows_decide_alone() -> None:
    """All scenarios as one batch."""
    gradients = torch.stack([pair(cosine, ratio) for _, cosine, ratio, _ in SCENARIOS])
    exploring = torch.tensor([before for before, *_ in SCENARIOS])

    memory = fresh(literal(), gradients) | {"exploring": exploring}
    _, state = resolve(literal(), gradients, memory)
    assert state["exploring"].tolist() == [after for *_, after in SCENARIOS]


@pytest.mark.parametrize(("strength", "conflicting"), [(0.5, True), (0.95, False)])
def test_a_third_gradient_decides_only_as_one_of_the_two_strongest(
    strength: float, conflicting: bool
) -> None:
    gradients = torch.tensor([[1.0, 0.0], [-0.9, 0.0], [0.0, strength]], dtype=torch.float64)
    assert explores(literal(), gradients) == conflicting


def test_the_asymmetric_thresholds_prevent_chattering() -> None:
    """A cosine that drifts up and down through both thresholds."""
    falling = {-0.5: False, -0.59: False, -0.61: True}
    rising = {-0.55: True, -0.45: True, -0.41: True, -0.39: False}
    falling_again = {-0.45: False, -0.55: False, -0.59: False, -0.65: True, -0.5: True}

    memory = fresh(literal(), pair(0.0))
    for drift in (falling, rising, falling_again):
        for cosine, exploring in drift.items():
            _, memory = resolve(literal(), pair(cosine), memory)
            assert bool(memory["exploring"]) == exploring


def test_the_dominance_ratio_is_of_the_normalised_magnitudes() -> None:
    """With τ = 0.8 lengths of 1 and 0.3 have weights of ratio 2.4.

    Λ = 3 does not end the conflict.
    """
    gradients = torch.tensor([[1.0, 0.0], [-0.3, 0.0]], dtype=torch.float64)
    assert explores(projection_in_paper(), gradients)
    assert not explores(literal(), gradients)


@pytest.mark.parametrize(
    ("speed", "curvature", "begins"), [(0.05, 0.0, True), (0.05, 50.0, False), (0.0, 50.0, True)]
)
def test_it_may_leave_be_what_tracks(speed: float, curvature: float, begins: bool) -> None:
    """Costs ∇ᵢ·d + c ‖d‖²/2: standing still costs more than a slope explains where they curve."""
    gradients = pair(-0.9)

    def displaced_cost(goal: str, shift: Tensor) -> Tensor:
        slope = gradients[..., int(goal[1:]), :]
        return (slope * shift).sum(-1) + 0.5 * curvature * shift.square().sum(-1)

    rule = NullspaceProjection(exploration=Exploration(unless_tracking=True))
    average = torch.tensor([speed, 0.0], dtype=gradients.dtype)
    memory = fresh(rule, gradients) | {"average": average}

    _, state = rule(gradient_stack(gradients, displaced_cost=displaced_cost), memory)
    assert bool(state["exploring"]) == begins
    assert explores(NullspaceProjection(), gradients)  # as shipped it does not ask


# --- in a graph


def two_arms() -> WorldModel:
    """Two independent quantities.

    The sensor places the conflict in one of them, in both or in none.
    """

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

    costs = (toward_left, against_left, toward_right, against_right)
    return WorldModel(
        sensors={"z": Sensor(2, "1")},
        actuators={"a": Actuator(2, "m"), "b": Actuator(2, "m")},
        estimators=[Deterministic("left", left), Deterministic("right", right)],
        goals=[Goal(cost.__name__, cost) for cost in costs],
        dtype=torch.float64,
    )


def test_memory_is_of_each_quantity() -> None:
    policy = Policy(two_arms(), literal(), DirectDescent(1.0, smoothing=0.0))
    conflicts = [(0, 0), (1, 0), (1, 1), (0, 1), (0, 0)]
    memories = rollout(policy, [{"z": torch.tensor(z, dtype=torch.float64)} for z in conflicts])

    for memory, expected in zip(memories, conflicts, strict=True):
        assert (int(memory["left/exploring"]), int(memory["right/exploring"])) == expected

    for name in ("rank", "cosine", "average", "exploring", "gradients"):
        assert f"left/{name}" in memories[0] and f"right/{name}" in memories[0]


@pytest.mark.parametrize("field", ["progress", "hold", "along"])
def test_an_escape_that_names_no_goal_of_the_model_is_an_error(field: str) -> None:
    escape = TrapEscape(**{field: "reech"})
    with pytest.raises(OptionError, match=r"'reech'.*'toward_left'"):
        Policy(two_arms(), literal(escape), DirectDescent(1.0))


# --- options


@pytest.mark.parametrize(
    ("options", "culprit"),
    [
        ({"enter_cosine": -0.3}, "enter_cosine=-0.3"),
        ({"enter_cosine": -1.1}, "enter_cosine"),
        ({"exit_cosine": 1.1}, "exit_cosine"),
        ({"exit_cosine": math.nan}, "exit_cosine"),
        ({"ratio": 0.9}, "ratio"),
        ({"average_time": 0.0}, "average_time"),
        ({"average_time": math.inf}, "average_time"),
        ({"ratio": "a"}, "ratio='a'"),
        ({"enter_cosine": None}, "enter_cosine=None"),
        ({"escape": None}, "escape=None: expected TrapEscape"),
        ({"opponent": "third"}, "opponent='third'.*'second' or 'opposing'"),
        ({"ratio_of": "costs"}, "ratio_of='costs'.*'weights' or 'magnitudes'"),
    ],
)
def test_bad_options_are_named(options: dict[str, Any], culprit: str) -> None:
    with pytest.raises(OptionError, match=culprit):
        Exploration(**options)
