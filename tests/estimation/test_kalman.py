"""On a linear system every filter is the textbook's Kalman filter."""

import math
from typing import Any

import numpy as np
import pytest
import torch
from _asserts import totals, update
from _inputs import BATCHES, MOVE, in_motion, tracked_point, tracking_model
from numpy.typing import NDArray
from torch import Tensor

from aicon_torch import EKF, Affine, Goal, Interconnection, KalmanFilter, Measurement

Array = NDArray[np.float64]

# A system with one input, and two sensors of one and two components.
A = np.array([[1.0, 0.1], [-0.05, 0.95]])
B = np.array([[0.0], [0.1]])
H1 = np.array([[1.0, 0.5]])
H2 = np.array([[1.0, 0.0], [0.3, 1.0]])
Q = np.diag([0.01, 0.04])
R = np.diag([0.2, 0.5, 0.1])


def textbook(actions: Array, z1: Array, z2: Array) -> tuple[Array, Array]:
    """Last mean and covariance of a Kalman filter, x⁺ = x + K (z − H x), both readings at once."""
    mean, covariance = np.array([1.0, -1.0]), np.diag([4.0, 9.0])
    h = np.vstack((H1, H2))

    for action, *readings in zip(actions, z1, z2, strict=True):
        mean, covariance = A @ mean + B @ action, A @ covariance @ A.T + Q

        gain = covariance @ h.T @ np.linalg.inv(h @ covariance @ h.T + R)
        mean = mean + gain @ (np.concatenate(readings) - h @ mean)
        covariance = (np.eye(2) - gain @ h) @ covariance

    return mean, covariance


OPTIONS: dict[str, Any] = {"noise": (0.01, 0.04), "initial": ((1.0, -1.0), (4.0, 9.0))}


def kalman_filter() -> KalmanFilter:
    """The filter of the system, given by its matrices."""
    first = Affine(x=torch.from_numpy(H1), z1=-1.0)
    second = Affine(x=torch.from_numpy(H2), z2=-1.0)

    prediction = Affine(x=torch.from_numpy(A), a=torch.from_numpy(B))
    correct = [Measurement(first, 0.2), Measurement(second, (0.5, 0.1), size=2)]
    return KalmanFilter("x", "P", predict=prediction, correct=correct, **OPTIONS)


def extended_filter() -> EKF:
    """The same, given by functions."""
    a, b, h1, h2 = (torch.from_numpy(matrix) for matrix in (A, B, H1, H2))

    def predict(x: Tensor, a_: Tensor) -> Tensor:
        return x @ a.mT + a_ @ b.mT

    def first(x: Tensor, z1: Tensor) -> Tensor:
        return x @ h1.mT - z1

    def second(x: Tensor, z2: Tensor) -> Tensor:
        return x @ h2.mT - z2

    correct = [Measurement(first, 0.2), Measurement(second, (0.5, 0.1), size=2)]
    prediction = Interconnection(predict, inputs=["x", "a"])
    return EKF("x", "P", predict=prediction, correct=correct, **OPTIONS)


@pytest.mark.parametrize("make", [kalman_filter, extended_filter])
@pytest.mark.parametrize("batch", BATCHES, ids=str)
def test_on_a_linear_system_it_is_the_textbook_s_kalman_filter(
    make: Any, batch: tuple[int, ...]
) -> None:
    rng = np.random.default_rng(0)
    steps, rows = 30, math.prod(batch)
    recorded = {
        name: rng.normal(size=(steps, rows, n)) for name, n in (("a", 1), ("z1", 1), ("z2", 2))
    }

    node: EKF = make()
    prior = node.initial({})
    values = {name: value.expand((*batch, *value.shape)) for name, value in prior.items()}

    for step in range(steps):
        for name, numbers in recorded.items():
            values[name] = torch.from_numpy(numbers[step]).reshape(*batch, -1)
        values |= update(node, values)

        if step in (0, steps - 1):
            means, covariances = values["x"].reshape(rows, 2), values["P"].reshape(rows, 2, 2)
            for row in range(rows):
                expected = textbook(*(numbers[: step + 1, row] for numbers in recorded.values()))
                assert np.allclose(means[row], expected[0], rtol=1e-10, atol=1e-12)
                assert np.allclose(covariances[row], expected[1], rtol=1e-10, atol=1e-12)


def test_linear_and_extended_filters_agree_in_a_graph() -> None:
    def uncertainty(p: Tensor, P: Tensor) -> Tensor:
        return (p**2).sum(-1) + P.diagonal(dim1=-2, dim2=-1).sum(-1)

    linear = KalmanFilter(
        "p",
        "P",
        predict=Affine(p=1.0, x=-1.0),
        noise=0.1,
        initial=((1.0, 2.0), 1.0),
        correct=[Measurement(Affine(p=1.0, z=-1.0), 0.1, size=2)],
    )
    goals = [Goal("both", uncertainty)]
    first = tracking_model(MOVE, linear, goals=goals)
    second = tracking_model(MOVE, tracked_point(), goals=goals)

    values, others = in_motion(first), in_motion(second)
    for name, value in values.items():
        torch.testing.assert_close(value, others[name])

    slopes = totals(first, values, {"a": values["a"]})
    torch.testing.assert_close(slopes, totals(second, others, {"a": others["a"]}))
