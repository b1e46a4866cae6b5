"""Implicit measurements: residuals, other estimates' uncertainty, and what is accepted."""

import pytest
import torch
from _inputs import BATCHES, normal, random_covariance
from torch import Tensor

from aicon_torch import Affine, GraphError, Measurement


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
        "P_hand": random_covariance(*batch, size=2),
    }

    measurement = Measurement(offset, 0.3, uncertain={"hand": "P_hand"}, size=2)
    assert set(measurement.inputs) == {"x", "hand", "z", "P_hand"}

    residual, jacobian, noise = measurement.innovation(values, "x")
    torch.testing.assert_close(residual, offset(values["x"], values["hand"], values["z"]))
    identity = torch.eye(2, dtype=torch.float64)
    torch.testing.assert_close(jacobian, (2.0 * identity).expand(*batch, 2, 2))
    torch.testing.assert_close(noise, 0.3 * identity + 4.0 * values["P_hand"])

    relation = Affine(x=2.0, hand=-2.0, z=-1.0)
    affine = Measurement(relation, 0.3, uncertain={"hand": "P_hand"}, size=2)
    found = affine.innovation(values, "x")
    for value, expected in zip(found, (residual, jacobian, noise), strict=True):
        torch.testing.assert_close(value.expand_as(expected), expected)


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
