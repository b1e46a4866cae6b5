"""Sensors, actuators and quantities."""

import math
from typing import Any

import numpy as np
import pytest
import torch
from _inputs import BATCHES, DTYPES, direction, normal, slower, where_to
from hypothesis import given
from hypothesis import strategies as st

from aicon_torch import Actuator, GraphError, Quantity, Sensor

LIMITS: list[tuple[int, Any]] = [
    (1, 0.3),
    (2, 0.3),
    (3, 2.0),
    (2, (0.3, 0.7)),
    (3, [0.1, 1.0, 10.0]),
    (2, math.inf),
]


def within(action: torch.Tensor, limit: Any) -> bool:
    """No component beyond the limit, nor the norm where it is one."""
    if not isinstance(limit, float):
        return bool((action.abs() <= action.new_tensor(limit)).all())

    rounding = 4 * torch.finfo(action.dtype).eps
    norm = torch.linalg.vector_norm(action, dim=-1)
    return bool((norm <= limit * (1 + rounding)).all() and (action.abs() <= limit).all())


@pytest.mark.parametrize("dtype", DTYPES, ids=str)
@pytest.mark.parametrize("batch", BATCHES, ids=str)
@pytest.mark.parametrize(("size", "limit"), LIMITS, ids=str)
def test_clipped_actions_respect_the_limit(
    dtype: torch.dtype, batch: tuple[int, ...], size: int, limit: Any
) -> None:
    actuator = Actuator(size, "m/s", limit)

    for scale in (0.0, 1e-3, 1.0, 1e3, 1e15):
        clipped = actuator.clip(scale * normal(*batch, size, dtype=dtype))
        assert clipped.shape == (*batch, size) and clipped.dtype == dtype
        assert within(clipped, limit)
        torch.testing.assert_close(actuator.clip(clipped), clipped)


def test_a_norm_limit_keeps_the_direction() -> None:
    actuator = Actuator(3, "m/s", 0.5)

    action = 10.0 * normal(5, 3)
    torch.testing.assert_close(actuator.clip(action), 0.5 * direction(action))

    inside = 0.05 * normal(5, 3)
    assert torch.equal(actuator.clip(inside), inside)


def test_component_limits_shorten_as_a_whole_where_the_direction_counts() -> None:
    actuator = Actuator(3, "rad/s", limit=(1.0, 2.0, 3.0), keeps_direction=True)
    clipped = actuator.clip(torch.tensor([2.0, 1.0, -1.0]))
    torch.testing.assert_close(clipped, torch.tensor([1.0, 0.5, -0.5]))

    within = torch.tensor([0.5, -2.0, 3.0])
    assert (actuator.clip(within) == within).all()


def test_component_limits_are_of_each_component() -> None:
    clipped = Actuator(2, "rad/s", (1.0, 2.0)).clip(torch.tensor([[3.0, -3.0], [0.1, 0.2]]))
    torch.testing.assert_close(clipped, torch.tensor([[1.0, -2.0], [0.1, 0.2]]))


@given(
    st.lists(st.floats(allow_nan=False, width=32), min_size=2, max_size=2),
    st.sampled_from([0.3, (0.3, 1.0)]),
)
def test_no_finite_or_infinite_action_escapes_the_limit(action: list[float], limit: Any) -> None:
    for dtype in DTYPES:
        assert within(Actuator(2, "m/s", limit).clip(torch.tensor(action, dtype=dtype)), limit)


def test_the_limit_knows_nothing_of_constraints_and_commands() -> None:
    """Those are the model's to apply: an actuator alone does not know what they read."""
    plain = Actuator(2, "m/s", 0.5)
    more = Actuator(2, "m/s", 0.5, constraints=[slower], command=where_to)
    assert (plain.constraints, plain.command) == ((), None)

    action = normal(3, 2)
    assert torch.equal(plain.clip(action), more.clip(action))


def test_constraints_are_a_sequence() -> None:
    with pytest.raises(GraphError, match="constraints .*expected a sequence of functions"):
        Actuator(2, "m/s", 0.5, constraints=lambda a: a)  # type: ignore[arg-type]


@pytest.mark.parametrize("wrong", [(1.0, 0.0), (0.0, 0.0), (0.0, math.nan)])
def test_a_range_of_commands_that_is_none_is_named(wrong: tuple[float, float]) -> None:
    with pytest.raises(GraphError, match=r"command_range .*expected \(lowest, highest\)"):
        Actuator(2, "m/s", 0.5, command=where_to, command_range=wrong)


def test_numbers_may_come_as_a_space_has_them() -> None:
    high = np.array([0.5, 0.7], dtype=np.float32)
    assert Actuator(2, "m/s", high[0]).limit == 0.5
    assert Actuator(2, "m/s", torch.tensor(0.5)).limit == 0.5
    assert Actuator(2, "m/s", high).limit == tuple(high.tolist())
    assert Sensor(2, "m", scale=np.array([1.0, 2.0])).scale == (1.0, 2.0)
    age: Any = np.array(0.2)
    assert type(Sensor(2, "m", max_age=age).max_age) is float


@pytest.mark.parametrize("limit", [0.0, -1.0, math.nan, (1.0, 0.0), (1.0, 2.0, 3.0), (), "1", None])
def test_a_limit_that_does_not_fit_is_named(limit: Any) -> None:
    with pytest.raises(GraphError, match=r"limit .*expected one positive number"):
        Actuator(2, "m/s", limit)


@pytest.mark.parametrize(
    ("options", "culprit"),
    [
        ({"size": 0}, "size 0"),
        ({"size": 1, "range": (2.0, 1.0)}, r"range \(2.0, 1.0\)"),
        ({"size": 1, "range": (0.0, math.nan)}, "range"),
        ({"size": 2.0}, "size 2.0"),
        ({"size": 1, "scale": 0.0}, r"scale 0.0: .*not 0"),
        ({"size": 1, "scale": math.nan}, "scale nan"),
        ({"size": 2, "range": ([0.0, 0.0], [1.0, 1.0])}, "range"),
        ({"size": 1, "period": math.inf}, "period=inf"),
        ({"size": 1, "age": -0.5}, "age=-0.5: expected a number >= 0, in s"),
        ({"size": 1, "age": math.nan}, "age=nan"),
        ({"size": 2, "scale": (1.0,)}, r"scale \(1.0,\): expected one factor, or 2"),
    ],
)
def test_a_sensor_that_cannot_be_is_named(options: dict[str, Any], culprit: str) -> None:
    with pytest.raises(GraphError, match=culprit):
        Sensor(unit="m", **options)


@pytest.mark.parametrize("shape", [(3,), (2, 2), (1,)])
def test_a_quantity_is_flattened_to_its_components(shape: tuple[int, ...]) -> None:
    quantity = Quantity("x", shape)

    for batch in BATCHES:
        value = normal(*batch, *shape)
        flat = quantity.flatten(value)
        assert flat.shape == (*batch, quantity.size)
        assert torch.equal(flat.reshape(value.shape), value)
