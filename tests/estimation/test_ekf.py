"""The extended filter: its step and its derivatives against the formulas, written out by hand."""

from typing import Any

import pytest
import torch
from _asserts import beacon_step, central_differences, slopes, update
from _inputs import (
    BATCHES,
    MOVE,
    beacon,
    beacon_values,
    bearing,
    drive,
    normal,
    tracking_model,
)
from torch import Tensor

from aicon_torch import EKF, Affine, DirectDescent, Interconnection, Measurement, Policy, Sum


@pytest.mark.parametrize("batch", BATCHES, ids=str)
def test_a_nonlinear_step_agrees_with_the_formula(batch: tuple[int, ...]) -> None:
    values = beacon_values(batch)
    updated = update(beacon(), values)

    expected = beacon_step(values)
    torch.testing.assert_close(updated["x"], expected.mean)
    torch.testing.assert_close(updated["P"], expected.covariance)


def test_the_derivative_of_the_mean_is_that_of_model_update_or_update_with_held_gain() -> None:
    values = beacon_values()
    by_model = central_differences(lambda v: drive(v["x"], v["a"]), values)
    by_update = central_differences(lambda v: beacon_step(v).mean, values)

    step = beacon_step(values)
    held = (torch.eye(2, dtype=torch.float64) - step.gain @ step.slope) @ by_model

    expected = {"model": by_model, "update": by_update, "detached_gain": held}
    for derivative, jacobian in expected.items():
        got = slopes(beacon(derivative=derivative), "x", values)
        torch.testing.assert_close(got, jacobian, rtol=1e-6, atol=1e-8)

    assert not torch.allclose(by_model, by_update, atol=1e-3)
    assert not torch.allclose(by_update, held, atol=1e-3)


@pytest.mark.parametrize("derivative", ["model", "update", "detached_gain"])
def test_the_derivative_of_the_covariance_is_that_of_the_next_update(derivative: Any) -> None:
    values = beacon_values()
    got = slopes(beacon(derivative=derivative), "P", values)

    expected = central_differences(lambda v: beacon_step(v).covariance, values)
    torch.testing.assert_close(got, expected, rtol=1e-6, atol=1e-8)


def test_anticipation_is_one_step_ahead() -> None:
    values = beacon_values((3,))
    expected = beacon_step(values)

    torch.testing.assert_close(beacon()(values, "x"), drive(values["x"], values["a"]))
    torch.testing.assert_close(beacon(derivative="update")(values, "x"), expected.mean)
    torch.testing.assert_close(beacon()(values, "P"), expected.covariance)


@pytest.mark.parametrize("known", [True, False], ids=["given Jacobian", "autograd"])
def test_given_jacobians_change_nothing(known: bool) -> None:
    def slope(x: Tensor) -> Tensor:
        across = torch.stack((-x[..., 1], x[..., 0]), dim=-1).unsqueeze(-2)
        return across / (x**2).sum(-1)[..., None, None]

    relation = Interconnection(bearing, x=slope) if known else Interconnection(bearing)
    node = beacon(correct=[Measurement(relation, 0.04)])

    values = beacon_values((2,))
    torch.testing.assert_close(update(node, values)["P"], beacon_step(values).covariance)

    alone = beacon_values()
    expected = central_differences(lambda v: beacon_step(v).covariance, alone)
    torch.testing.assert_close(slopes(node, "P", alone), expected, rtol=1e-6, atol=1e-8)


def test_a_filter_that_only_predicts_remembers_no_gradient() -> None:
    """Its prediction is linearised under autograd.

    Neither that nor its own last value may stay in the memory.
    """
    for size in (1, 2):

        def drift(p: Tensor, x: Tensor, size: int = size) -> Tensor:
            return torch.sin(p) + x[..., :size]

        alone = EKF("p", "P", predict=drift, noise=0.1, initial=((0.3, 0.2)[:size], 1.0))
        policy = Policy(tracking_model(MOVE, alone), Sum(), DirectDescent(1.0))

        memory = None
        for _ in range(3):
            _, memory = policy.predict({"z": normal(2)}, memory)
            assert not [name for name, value in memory.items() if value.requires_grad]


# --- another estimate's uncertainty


@pytest.mark.parametrize("spread", [0.0, 1.0, 100.0])
def test_an_uncertain_partner_teaches_less(spread: float) -> None:
    """The correction by a relation to another estimate, whose covariance enters S, by hand in one
    dimension.
    """

    def apart(x: Tensor, hand: Tensor, z: Tensor) -> Tensor:
        return x - hand - z

    node = EKF(
        "x",
        "P",
        predict=Affine(x=1.0),
        noise=0.0,
        initial=((0.0,), 4.0),
        correct=[Measurement(apart, 1.0, uncertain={"hand": "P_hand"})],
    )
    one = torch.ones(1, dtype=torch.float64)
    values = {
        "x": 0 * one,
        "P": 4 * one[None],
        "hand": one,
        "P_hand": spread * one[None],
        "z": 2 * one,
    }
    updated = update(node, values)

    gain = 4.0 / (4.0 + 1.0 + spread)
    assert float(updated["x"]) == pytest.approx(3.0 * gain)
    assert float(updated["P"]) == pytest.approx(4.0 * (1.0 - gain))
