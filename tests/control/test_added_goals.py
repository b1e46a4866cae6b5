"""Goals that are added to the navigation graph without touching a module."""

from collections.abc import Callable

import pytest
import torch
from _inputs import drifting, navigation, with_goal, with_law
from torch import Tensor
from torch.nn.functional import normalize

from aicon_torch import Goal

GOALS: dict[str, Callable[..., Tensor]] = {
    "p_tar": lambda p_tar: 0.0 * p_tar[..., 0],
    "P_tar": lambda P_tar: 0.0 * P_tar[..., 0, 0],
    "x_obs": lambda x_obs: 0.0 * x_obs[..., 0],
    "x_rob": lambda x_rob: 0.0 * x_rob[..., 0],
    "a": lambda a: 0.0 * a[..., 0],
}


OFTEN = ("x_obs", "a")
"""An estimate and an action; the others with the slow tests."""


@pytest.mark.parametrize(
    "quantity",
    [pytest.param(name, marks=[pytest.mark.slow] * (name not in OFTEN)) for name in GOALS],
)
def test_a_goal_that_asks_for_nothing_changes_nothing(quantity: str) -> None:
    """Wherever it arrives, and though other gradients then meet it there, exploration included.

    At x_rob it takes a share in the softmax, which shortens the sum and does not turn it.
    """
    plain, more = (
        with_law(policy, iterations=1)
        for policy in (navigation(), with_goal(Goal("nothing", GOALS[quantity])))
    )
    compared = "a/gradient" if quantity == "x_rob" else "a"
    memory = other = None
    explored = False

    for readings in drifting(24):
        # Compared step by step: rounding errors must not add up.
        if memory is not None and other is not None:
            other |= {name: memory[name] for name in plain.model.quantities}

        _, memory = plain.predict(readings, memory)
        _, other = more.predict(readings, other)
        explored |= bool(memory["x_rob/exploring"])

        expected, found = memory[compared], other[compared]
        if quantity == "x_rob":
            expected, found = (normalize(gradient, dim=-1) for gradient in (expected, found))
        torch.testing.assert_close(found, expected, rtol=1e-7, atol=1e-9)

    assert explored


def test_a_repelling_goal_on_the_clearance_keeps_more_distance() -> None:
    careful = with_goal(Goal("wide berth", lambda x_obs: 5.0 * torch.exp(-x_obs[..., 0] / 0.5)))
    still = {
        "bearing": torch.zeros(1, dtype=torch.float64),
        "range": torch.tensor([0.5], dtype=torch.float64),
    }

    _, plain = navigation().predict(still)
    _, wide = careful.predict(still)
    assert "x_obs/gradients" in wide
    assert "x_obs/gradients" not in plain
