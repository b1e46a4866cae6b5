"""On a linear system every filter is the textbook's Kalman filter."""

import math
from typing import Any

import numpy as np
import pytest
import torch
from _asserts import totals, update
from _inputs import BATCHES, in_motion, move, tracked_point, tracking_model
from numpy.typing import NDArray
from torch import Tensor

from aicon_torch import EKF, Affine, Deterministic, Goal, KalmanFilter, Measurement

Array = NDArray[np.float64]


A = np.array([[1.0, 0.1], [-0.05, 0.95]])


B = np.array([[0.0], [0.1]])


H1, R1 = np.array([[1.0, 0.5]]), np.array([[0.2]])


H2, R2 = np.array([[1.0, 0.0], [0.3, 1.0]]), np.diag([0.5, 0.1])


Q = np.diag([0.01, 0.04])


def textbook(actions: Array, z1: Array, z2: Array) -> tuple[Array, Array]:
    """Means and covariances of a Kalman filter, x⁺ = x + K (z − H x), in numpy.

    Both readings at once.
    """
    mean, cov = np.array([1.0, -1.0]), np.diag([4.0, 9.0])
    h, r = np.vstack((H1, H2)), np.block([[R1, np.zeros((1, 2))], [np.zeros((2, 1)), R2]])
    means, covs = [], []

    for action, first, second in zip(actions, z1, z2, strict=True):
        mean, cov = A @ mean + B @ action, A @ cov @ A.T + Q
        gain = cov @ h.T @ np.linalg.inv(h @ cov @ h.T + r)
        mean = mean + gain @ (np.concatenate((first, second)) - h @ mean)
        cov = (np.eye(2) - gain @ h) @ cov
        means.append(mean)
        covs.append(cov)

    return np.array(means), np.array(covs)


def matrix(values: Array) -> Tensor:
    return torch.from_numpy(values)


def linear_filter(kind: str) -> EKF:
    first = Affine(x=matrix(H1), z1=-1.0)
    second = Affine(x=matrix(H2), z2=-1.0)
    options: Any = {"noise": (0.01, 0.04), "initial": ((1.0, -1.0), (4.0, 9.0))}

    if kind == "kalman":
        correct = [Measurement(first, 0.2), Measurement(second, (0.5, 0.1), size=2)]
        return KalmanFilter(
            "x", "P", predict=Affine(x=matrix(A), a=matrix(B)), correct=correct, **options
        )

    def predict(x: Tensor, a: Tensor) -> Tensor:
        return x @ matrix(A).mT + a @ matrix(B).mT

    def h1(x: Tensor, z1: Tensor) -> Tensor:
        return x @ matrix(H1).mT - z1

    def h2(x: Tensor, z2: Tensor) -> Tensor:
        return x @ matrix(H2).mT - z2

    correct = [Measurement(h1, 0.2), Measurement(h2, (0.5, 0.1), size=2)]
    return EKF("x", "P", predict=predict, correct=correct, **options)


@pytest.mark.parametrize("kind", ["kalman", "ekf"])
@pytest.mark.parametrize("batch", BATCHES, ids=str)
def test_on_a_linear_system_it_is_the_textbook_s_kalman_filter(
    kind: str, batch: tuple[int, ...]
) -> None:
    rng = np.random.default_rng(0)
    steps, rows = 30, math.prod(batch)
    actions, z1, z2 = (rng.normal(size=(steps, rows, size)) for size in (1, 1, 2))
    node = linear_filter(kind)
    values: dict[str, Any] = {k: v.expand((*batch, *v.shape)) for k, v in node.initial({}).items()}

    for step in range(steps):
        now = {"a": actions[step], "z1": z1[step], "z2": z2[step]}
        values |= {name: torch.from_numpy(x).reshape(*batch, -1) for name, x in now.items()}
        values |= update(node, values)

        for row in range(rows):
            mean, cov = textbook(actions[: step + 1, row], z1[: step + 1, row], z2[: step + 1, row])
            if step in (0, steps - 1):
                assert np.allclose(
                    values["x"].reshape(rows, 2)[row], mean[-1], rtol=1e-10, atol=1e-12
                )
                assert np.allclose(
                    values["P"].reshape(rows, 2, 2)[row], cov[-1], rtol=1e-10, atol=1e-12
                )


def test_linear_and_extended_filters_agree_in_a_graph() -> None:
    linear = KalmanFilter("p", "P", predict=Affine(p=1.0, x=-1.0), noise=0.1, initial=((1.0, 2.0), 1.0), correct=[
        Measurement(Affine(p=1.0, z=-1.0), 0.1, size=2)
    ])  # fmt: skip
    uncertainty = Goal("both", lambda p, P: (p**2).sum(-1) + P.diagonal(dim1=-2, dim2=-1).sum(-1))
    graphs = [
        tracking_model(Deterministic("x", move), node, goals=[uncertainty])
        for node in (linear, tracked_point())
    ]
    values = [in_motion(graph) for graph in graphs]
    slopes = [totals(g, v, {"a": v["a"]})["a"] for g, v in zip(graphs, values, strict=True)]
    for name in values[0]:
        torch.testing.assert_close(values[0][name], values[1][name])

    torch.testing.assert_close(*slopes)
