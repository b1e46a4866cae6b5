"""Kalman corrections and implicit measurements, against the textbook's formulas."""

from typing import Any

import numpy as np
import pytest
import torch
from _inputs import BATCHES, normal
from torch import Tensor

from aicon_torch import Affine, GraphError, Measurement
from aicon_torch.estimation import Correction, Covariance


def covariance(*batch: int, size: int, seed: int = 0) -> Tensor:
    root = normal(*batch, size, size, seed=seed)
    return root @ root.mT + 0.1 * torch.eye(size, dtype=torch.float64)


@pytest.mark.parametrize("batch", BATCHES, ids=str)
@pytest.mark.parametrize("rows", [1, 2, 3])
def test_a_correction_is_the_textbook_s(batch: tuple[int, ...], rows: int) -> None:
    p, noise = covariance(*batch, size=3), covariance(*batch, size=rows, seed=1)
    residual, jacobian = normal(*batch, rows, seed=2), normal(*batch, rows, 3, seed=3)
    step = Correction.by(p, jacobian, noise)
    spread = jacobian @ p @ jacobian.mT + noise
    gain = p @ jacobian.mT @ torch.linalg.inv(spread)
    torch.testing.assert_close(step.of_mean(residual), (gain @ residual.unsqueeze(-1)).squeeze(-1))
    torch.testing.assert_close(step.of_covariance(), gain @ spread @ gain.mT)
    torch.testing.assert_close(step.of_covariance(), step.of_covariance().mT, rtol=1e-14, atol=1e-14)
    mahalanobis = residual.unsqueeze(-2) @ torch.linalg.inv(spread) @ residual.unsqueeze(-1)
    torch.testing.assert_close(step.distance(residual), mahalanobis.squeeze(-1).squeeze(-1))


def test_the_distance_divides_by_the_spread() -> None:
    """νᵀS⁻¹ν, not νᵀSν: a residual of 2 with S = 16 is 0.25 away."""
    one = torch.ones(1, 1, dtype=torch.float64)
    step = Correction.by(12.0 * one, one, 4.0 * one)
    assert float(step.distance(torch.tensor([2.0], dtype=torch.float64))) == pytest.approx(0.25)


def test_a_detached_gain_carries_no_gradient() -> None:
    p, residual = covariance(size=2).requires_grad_(), normal(1, seed=1).requires_grad_()
    step = Correction.by(p, normal(1, 2, seed=2), torch.ones(1, 1, dtype=torch.float64))
    by_p, by_residual = torch.autograd.grad(
        step.of_mean(residual, detach_gain=True).sum(), (p, residual), allow_unused=True
    )
    assert by_p is None
    torch.testing.assert_close(by_residual, step.gain.sum(-1).detach())
    assert torch.autograd.grad(step.of_mean(residual).sum(), p)[0].any()


@pytest.mark.parametrize(
    ("noise", "size", "expected"),
    [(0.25, 2, [0.25, 0.25]), ((1.0, 4.0), 2, [1.0, 4.0]), (0.0, 1, [0.0]), (np.array([1.0, 2.0]), 2, [1.0, 2.0])],
)
def test_constant_noise_is_a_diagonal(noise: Any, size: int, expected: list[float]) -> None:
    torch.testing.assert_close(Covariance(noise, size)({}), torch.diag(torch.tensor(expected, dtype=torch.float64)))


@pytest.mark.parametrize("noise", [-1.0, (1.0, 2.0, 3.0), (1.0, -2.0), float("nan"), [[1.0]]])
def test_bad_noise_is_named(noise: Any) -> None:
    with pytest.raises(GraphError, match=r"noise=.*expected one variance >= 0 or 2"):
        Covariance(noise, 2)


def test_noise_may_be_a_function_of_quantities() -> None:
    """Such as of the age of a late reading."""
    noise = Covariance(lambda age: (0.1 + age) ** 2, 1)
    assert noise.inputs == ("age",)
    ages = torch.tensor([[0.0], [0.9]], dtype=torch.float64)
    assert noise({"age": ages}).tolist() == [[[pytest.approx(0.01)]], [[pytest.approx(1.0)]]]


def offset(x: Tensor, hand: Tensor, z: Tensor) -> Tensor:
    """The reading is the distance of two estimates, doubled."""
    return 2.0 * (x - hand) - z


@pytest.mark.parametrize("batch", BATCHES, ids=str)
def test_the_uncertainty_of_another_estimate_adds_to_the_noise(batch: tuple[int, ...]) -> None:
    """R + H₂ P₂ H₂ᵀ by hand, with H₂ = −2 I."""
    values = {
        "x": normal(*batch, 2, seed=1),
        "hand": normal(*batch, 2, seed=2),
        "z": normal(*batch, 2, seed=3),
        "P_hand": covariance(*batch, size=2),
    }
    measurement = Measurement(offset, 0.3, uncertain={"hand": "P_hand"}, size=2)
    assert set(measurement.inputs) == {"x", "hand", "z", "P_hand"}
    residual, jacobian, noise = measurement.innovation(values, "x")
    torch.testing.assert_close(residual, offset(values["x"], values["hand"], values["z"]))
    torch.testing.assert_close(jacobian, (2.0 * torch.eye(2, dtype=torch.float64)).expand(*batch, 2, 2))
    expected = 0.3 * torch.eye(2, dtype=torch.float64) + 4.0 * values["P_hand"]
    torch.testing.assert_close(noise, expected)
    affine = Measurement(Affine(x=2.0, hand=-2.0, z=-1.0), 0.3, uncertain={"hand": "P_hand"}, size=2)
    for got, want in zip(affine.innovation(values, "x"), (residual, jacobian, noise), strict=True):
        torch.testing.assert_close(got.expand_as(want), want)


def test_an_uncertain_estimate_that_is_not_read_is_named() -> None:
    with pytest.raises(GraphError, match=r"'x', 'hand', 'z', not 'foot'"):
        Measurement(offset, 0.3, uncertain={"foot": "P_foot"}, size=2)


def test_what_is_accepted_depends_on_the_gate_and_on_presence() -> None:
    distance = torch.tensor([0.5, 8.9, 9.1, 100.0, float("nan")])
    assert Measurement(offset, 1.0).accepted({}, lambda: distance) is None
    gated = Measurement(offset, 1.0, gate=9.0)
    accepted = gated.accepted({}, lambda: distance)
    assert accepted is not None and accepted.tolist() == [True, True, False, False, False]
    gated.optional = ("z.present",)
    present = torch.tensor([False, True, True, True, True])
    accepted = gated.accepted({"z.present": present}, lambda: distance)
    assert accepted is not None and accepted.tolist() == [False, True, False, False, False]
