"""The noise of predictions and measurements: constant, or a function of quantities."""

from typing import Any

import numpy as np
import pytest
import torch

from aicon_torch import GraphError
from aicon_torch.estimation import Covariance


@pytest.mark.parametrize(
    ("noise", "size", "expected"),
    [
        (0.25, 2, [0.25, 0.25]),
        ((1.0, 4.0), 2, [1.0, 4.0]),
        (0.0, 1, [0.0]),
        (np.array([1.0, 2.0]), 2, [1.0, 2.0]),
    ],
)
def test_constant_noise_is_a_diagonal(noise: Any, size: int, expected: list[float]) -> None:
    diagonal = torch.diag(torch.tensor(expected, dtype=torch.float64))
    torch.testing.assert_close(Covariance(noise, size)({}), diagonal)


@pytest.mark.parametrize(
    "noise",
    [-1.0, (1.0, 2.0, 3.0), (1.0, -2.0), float("nan"), [[1.0]], np.inf, "a", ["a", "b"], None],
)
def test_bad_noise_is_named(noise: Any) -> None:
    with pytest.raises(GraphError, match=r"noise=.*expected one variance >= 0 or 2"):
        Covariance(noise, 2)


def test_noise_may_be_a_function_of_quantities() -> None:
    """Such as of the age of a late reading."""
    noise = Covariance(lambda age: (0.1 + age) ** 2, 1)
    assert noise.inputs == ("age",)

    ages = torch.tensor([[0.0], [0.9]], dtype=torch.float64)
    assert noise({"age": ages}).tolist() == [[[pytest.approx(0.01)]], [[pytest.approx(1.0)]]]
