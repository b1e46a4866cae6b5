"""The paper's action law: one gradient a step, at the current estimates."""

import math
from typing import Any

import pytest
import torch
from _inputs import BATCHES, DTYPES, normal
from hypothesis import given
from hypothesis import strategies as st
from torch import Tensor

from aicon_torch import Actuator, DirectDescent, OptionError

FREE = Actuator(2, "m/s")


def act(
    law: DirectDescent, gradient: Tensor, last: Tensor, actuator: Actuator, dt: float
) -> Tensor:
    """The action of a control step, from its one gradient and the last action."""
    count = torch.ones((), dtype=gradient.dtype)
    start = law.start(last, torch.zeros(last.shape[:-1]), actuator)
    descended = law.descend(start, gradient, count, actuator)
    return law.finish(descended, last, actuator, dt)


def test_the_paper_accumulates() -> None:
    assert DirectDescent.as_in_paper(gain=3.0) == DirectDescent(3.0, accumulate=True)
    assert not DirectDescent().accumulate


@pytest.mark.parametrize("batch", BATCHES, ids=str)
def test_the_action_descends_the_gradient(batch: tuple[int, ...]) -> None:
    gradient, action = normal(*batch, 2, seed=1), normal(*batch, 2, seed=2)
    law = DirectDescent(3.0, smoothing=0.0)
    torch.testing.assert_close(act(law, gradient, action, FREE, 0.05), -3.0 * gradient)


def test_it_accumulates_as_in_eq_2() -> None:
    law = DirectDescent(0.5, accumulate=True, smoothing=0.0)
    gradient = torch.tensor([1.0, -2.0], dtype=torch.float64)

    action = torch.zeros(2, dtype=torch.float64)
    for _ in range(4):
        action = act(law, gradient, action, FREE, 0.05)

    assert action.tolist() == [-2.0, 4.0]


@pytest.mark.parametrize(("dt", "smoothing"), [(0.05, 0.1), (0.1, 0.2), (0.05, 2.0)])
@pytest.mark.parametrize("accumulate", [False, True])
def test_the_low_pass_closes_a_share_of_the_gap(
    dt: float, smoothing: float, accumulate: bool
) -> None:
    """a ← a + α (a* − a) with α = dt/(dt + T), also after accumulating."""
    gradient, action = normal(2, seed=1), normal(2, seed=2)
    nominal = action - gradient if accumulate else -gradient
    share = dt / (dt + smoothing)
    law = DirectDescent(1.0, accumulate, smoothing)

    torch.testing.assert_close(
        act(law, gradient, action, FREE, dt), action + share * (nominal - action)
    )


@pytest.mark.parametrize("dtype", DTYPES, ids=str)
@pytest.mark.parametrize("limit", [0.3, (0.3, 0.7)], ids=str)
@pytest.mark.parametrize("accumulate", [False, True])
@pytest.mark.parametrize("smoothing", [0.0, 0.1])
def test_the_limit_holds_at_every_step(
    dtype: torch.dtype, limit: Any, accumulate: bool, smoothing: float
) -> None:
    actuator, law = Actuator(2, "m/s", limit), DirectDescent(20.0, accumulate, smoothing)
    action = torch.zeros(7, 2, dtype=dtype)

    for step in range(30):
        action = act(law, 100.0 * normal(7, 2, seed=step, dtype=dtype), action, actuator, 0.05)
        if isinstance(limit, float):
            assert (action.norm(dim=-1) <= limit * (1 + 1e-6)).all()
            assert (action.abs() <= limit).all()
        else:
            assert (action.abs() <= torch.tensor(limit, dtype=dtype)).all()


@given(
    st.lists(st.floats(allow_nan=False, width=32), min_size=2, max_size=2),
    st.booleans(),
    st.sampled_from([0.0, 0.1]),
)
def test_no_gradient_however_large_breaks_the_limit(
    gradient: list[float], accumulate: bool, smoothing: float
) -> None:
    law = DirectDescent(20.0, accumulate, smoothing)
    action = act(
        law, torch.tensor(gradient), torch.tensor([0.1, 0.2]), Actuator(2, "m/s", 0.5), 0.05
    )
    assert (action.abs() <= 0.5).all()  # false for NaN


@pytest.mark.parametrize(
    ("options", "culprit"),
    [
        ({"gain": 0.0}, "gain=0.0"),
        ({"gain": -1.0}, "gain=-1.0"),
        ({"gain": math.nan}, "gain=nan"),
        ({"gain": None}, "gain=None"),
        ({"gain": 1.0, "smoothing": -0.1}, "smoothing=-0.1"),
    ],
)
def test_bad_constants_are_named(options: dict[str, Any], culprit: str) -> None:
    with pytest.raises(OptionError, match=culprit):
        DirectDescent(**options)
