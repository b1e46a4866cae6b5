"""Estimators: textbook filters, what their derivatives are, gates, missing and late readings."""

import math
from typing import Any

import numpy as np
import pytest
import torch
from _inputs import BATCHES, normal
from numpy.typing import NDArray
from torch import Tensor, nn

from aicon_torch import (
    EKF,
    ActionLaw,
    Actuator,
    Affine,
    Estimator,
    Deterministic,
    Goal,
    GraphError,
    Interconnection,
    KalmanFilter,
    Measurement,
    Policy,
    Sensor,
    Sum,
    WorldModel,
)

Array = NDArray[np.float64]

A = np.array([[1.0, 0.1], [-0.05, 0.95]])
B = np.array([[0.0], [0.1]])
H1, R1 = np.array([[1.0, 0.5]]), np.array([[0.2]])
H2, R2 = np.array([[1.0, 0.0], [0.3, 1.0]]), np.diag([0.5, 0.1])
Q = np.diag([0.01, 0.04])


def update(node: Estimator, values: dict[str, Tensor]) -> dict[str, Tensor]:
    """As the graph runs it: filtering is not differentiated."""
    with torch.no_grad():
        return node.update(values)


def textbook(actions: Array, z1: Array, z2: Array) -> tuple[Array, Array]:
    """Means and covariances of a Kalman filter, x⁺ = x + K (z − H x), in numpy; both readings at once."""
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
    if kind == "linear":
        correct = [Measurement(first, 0.2), Measurement(second, (0.5, 0.1), size=2)]
        return KalmanFilter("x", "P", predict=Affine(x=matrix(A), a=matrix(B)), correct=correct, **options)

    def predict(x: Tensor, a: Tensor) -> Tensor:
        return x @ matrix(A).mT + a @ matrix(B).mT

    def h1(x: Tensor, z1: Tensor) -> Tensor:
        return x @ matrix(H1).mT - z1

    def h2(x: Tensor, z2: Tensor) -> Tensor:
        return x @ matrix(H2).mT - z2

    correct = [Measurement(h1, 0.2), Measurement(h2, (0.5, 0.1), size=2)]
    return EKF("x", "P", predict=predict, correct=correct, **options)


@pytest.mark.parametrize("kind", ["linear", "ekf"])
@pytest.mark.parametrize("batch", BATCHES, ids=str)
def test_on_a_linear_system_it_is_the_textbook_s_kalman_filter(kind: str, batch: tuple[int, ...]) -> None:
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
                assert np.allclose(values["x"].reshape(rows, 2)[row], mean[-1], rtol=1e-10, atol=1e-12)
                assert np.allclose(values["P"].reshape(rows, 2, 2)[row], cov[-1], rtol=1e-10, atol=1e-12)


# --- a nonlinear one: a beacon is seen under an angle


def drive(x: Tensor, a: Tensor) -> Tensor:
    return x + 0.1 * torch.stack((torch.cos(a[..., 0]) * a[..., 1], torch.sin(a[..., 0]) * a[..., 1]), dim=-1)


def angle(x: Tensor, z: Tensor) -> Tensor:
    return torch.atan2(x[..., 1:], x[..., :1]) - z


def beacon(**options: Any) -> EKF:
    settings: Any = {"noise": 0.01, "initial": ((2.0, 1.0), 0.5), "correct": [Measurement(angle, 0.04)]} | options
    return EKF("x", "P", predict=drive, **settings)


def at(batch: tuple[int, ...] = (), seed: int = 0, **known: Tensor) -> dict[str, Tensor]:
    root = normal(*batch, 2, 2, seed=seed)
    values = {
        "x": torch.tensor([2.0, 1.0], dtype=torch.float64) + 0.3 * normal(*batch, 2, seed=seed + 1),
        "P": root @ root.mT + 0.2 * torch.eye(2, dtype=torch.float64),
        "a": normal(*batch, 2, seed=seed + 2),
        "z": 0.5 + 0.1 * normal(*batch, 1, seed=seed + 3),
    }
    return values | known


def by_hand(values: dict[str, Tensor]) -> tuple[Tensor, Tensor, Tensor]:
    """Mean and covariance after one step of the beacon's filter, and the gain; F = I, H written out."""
    mean, cov = drive(values["x"], values["a"]), values["P"] + 0.01 * torch.eye(2, dtype=torch.float64)
    row = torch.stack((-mean[..., 1], mean[..., 0]), dim=-1).unsqueeze(-2) / (mean**2).sum(-1)[..., None, None]
    gain = cov @ row.mT / (row @ cov @ row.mT + 0.04)
    corrected = mean - (gain * angle(mean, values["z"]).unsqueeze(-1)).squeeze(-1)
    return corrected, cov - gain @ row @ cov, gain


@pytest.mark.parametrize("batch", BATCHES, ids=str)
def test_a_nonlinear_step_agrees_with_the_formula(batch: tuple[int, ...]) -> None:
    values = at(batch)
    updated = update(beacon(), values)
    mean, cov, _ = by_hand(values)
    torch.testing.assert_close(updated["x"], mean)
    torch.testing.assert_close(updated["P"], cov)


def slopes(node: EKF, output: str, values: dict[str, Tensor]) -> Tensor:
    """∂output/∂a, full Jacobian."""

    def ahead(a: Tensor) -> Tensor:
        out: Tensor = node({**values, "a": a}, output)
        return out

    jacobian: Tensor = torch.autograd.functional.jacobian(ahead, values["a"])
    return jacobian


def numeric(function: Any, values: dict[str, Tensor], step: float = 1e-6) -> Tensor:
    columns = []
    for shift in step * torch.eye(2, dtype=torch.float64):
        up, down = (function({**values, "a": values["a"] + sign * shift}) for sign in (1, -1))
        columns.append((up - down) / (2 * step))
    return torch.stack(columns, dim=-1)


def test_the_derivative_of_the_mean_is_that_of_the_model_the_update_or_the_update_with_its_gain_held() -> None:
    values = at()
    by_model = numeric(lambda v: drive(v["x"], v["a"]), values)
    by_update = numeric(lambda v: by_hand(v)[0], values)
    _, _, gain = by_hand(values)
    mean = drive(values["x"], values["a"])
    row = torch.stack((-mean[1], mean[0])).unsqueeze(0) / (mean**2).sum()
    held = (torch.eye(2, dtype=torch.float64) - gain @ row) @ by_model
    for derivative, expected in (("model", by_model), ("update", by_update), ("detached_gain", held)):
        got = slopes(beacon(derivative=derivative), "x", values)
        torch.testing.assert_close(got, expected, rtol=1e-6, atol=1e-8)
    assert not torch.allclose(by_model, by_update, atol=1e-3) and not torch.allclose(by_update, held, atol=1e-3)


@pytest.mark.parametrize("derivative", ["model", "update", "detached_gain"])
def test_the_derivative_of_the_covariance_is_that_of_the_next_update(derivative: Any) -> None:
    values = at()
    node = beacon(derivative=derivative)
    expected = numeric(lambda v: by_hand(v)[1], values)
    torch.testing.assert_close(slopes(node, "P", values), expected, rtol=1e-6, atol=1e-8)


def test_anticipation_is_one_step_ahead() -> None:
    values = at((3,))
    torch.testing.assert_close(beacon()(values, "x"), drive(values["x"], values["a"]))
    torch.testing.assert_close(beacon(derivative="update")(values, "x"), by_hand(values)[0])
    torch.testing.assert_close(beacon()(values, "P"), by_hand(values)[1])


@pytest.mark.parametrize("known", [True, False], ids=["given Jacobian", "autograd"])
def test_given_jacobians_change_nothing(known: bool) -> None:
    def slope(x: Tensor) -> Tensor:
        return torch.stack((-x[..., 1], x[..., 0]), dim=-1).unsqueeze(-2) / (x**2).sum(-1)[..., None, None]

    relation = Interconnection(angle, x=slope) if known else Interconnection(angle)
    node = beacon(correct=[Measurement(relation, 0.04)])
    values = at((2,))
    torch.testing.assert_close(update(node, values)["P"], by_hand(values)[1])
    alone = at()
    expected = numeric(lambda v: by_hand(v)[1], alone)
    torch.testing.assert_close(slopes(node, "P", alone), expected, rtol=1e-6, atol=1e-8)


# --- the outlier gate


def distance(values: dict[str, Tensor]) -> Tensor:
    """νᵀS⁻¹ν of the beacon's reading, by hand."""
    mean, cov = drive(values["x"], values["a"]), values["P"] + 0.01 * torch.eye(2, dtype=torch.float64)
    row = torch.stack((-mean[..., 1], mean[..., 0]), dim=-1) / (mean**2).sum(-1, keepdim=True)
    spread = torch.einsum("...i,...ij,...j->...", row, cov, row) + 0.04
    return angle(mean, values["z"]).squeeze(-1) ** 2 / spread


def test_the_gate_refuses_outliers_row_by_row() -> None:
    values = at((6,), z=torch.tensor([[0.4], [0.5], [1.0], [2.0], [-2.0], [0.45]], dtype=torch.float64))
    believed = distance(values) <= 2.0
    assert believed.any() and not believed.all()
    node = beacon(correct=[Measurement(angle, 0.04, gate=2.0)])
    updated = update(node, values)
    mean, cov, _ = by_hand(values)
    predicted = values["P"] + 0.01 * torch.eye(2, dtype=torch.float64)
    torch.testing.assert_close(updated["x"], torch.where(believed[:, None], mean, drive(values["x"], values["a"])))
    torch.testing.assert_close(updated["P"], torch.where(believed[:, None, None], cov, predicted))


@pytest.mark.parametrize("keeps", [True, False])
def test_the_gate_can_keep_the_gradient_of_the_covariance(keeps: bool) -> None:
    refused, believed = at(z=torch.tensor([3.0], dtype=torch.float64)), at(z=torch.tensor([0.5], dtype=torch.float64))
    node = beacon(correct=[Measurement(angle, 0.04, gate=2.0, gate_keeps_gradient=keeps)])
    torch.testing.assert_close(slopes(node, "P", believed), slopes(beacon(), "P", believed))
    kept = slopes(node, "P", refused)
    torch.testing.assert_close(kept, slopes(beacon(), "P", refused) if keeps else torch.zeros_like(kept))


@pytest.mark.parametrize("derivative", ["update", "detached_gain"])
def test_a_refused_reading_shapes_the_mean_no_more_than_the_covariance(derivative: Any) -> None:
    refused = at(z=torch.tensor([3.0], dtype=torch.float64))
    for keeps in (True, False):
        measurement = Measurement(angle, 0.04, gate=2.0, gate_keeps_gradient=keeps)
        got = slopes(beacon(correct=[measurement], derivative=derivative), "x", refused)
        expected = slopes(beacon(derivative=derivative if keeps else "model"), "x", refused)
        torch.testing.assert_close(got, expected)


# --- another estimate's uncertainty, in a filter


def test_an_uncertain_partner_teaches_less() -> None:
    """The correction by a relation to another estimate, whose covariance enters S, by hand in one dimension."""

    def apart(x: Tensor, hand: Tensor, z: Tensor) -> Tensor:
        return x - hand - z

    for spread in (0.0, 1.0, 100.0):
        node = EKF(
            "x",
            "P",
            predict=Affine(x=1.0),
            noise=0.0,
            initial=((0.0,), 4.0),
            correct=[Measurement(apart, 1.0, uncertain={"hand": "P_hand"})],
        )
        one = torch.ones(1, dtype=torch.float64)
        values = {"x": 0 * one, "P": 4 * one[None], "hand": one, "P_hand": spread * one[None], "z": 2 * one}
        updated = update(node, values)
        gain = 4.0 / (4.0 + 1.0 + spread)
        assert float(updated["x"]) == pytest.approx(3.0 * gain)
        assert float(updated["P"]) == pytest.approx(4.0 * (1.0 - gain))


# --- missing and late readings, in a graph


def seen(x: Tensor, z: Tensor) -> Tensor:
    return x - z


def tracker(optional: bool = True, **options: Any) -> Policy:
    measurement = Measurement(seen, options.pop("noise", 0.1), size=2, **options)
    model = WorldModel(
        sensors={"z": Sensor(2, "m", optional=optional), "age": Sensor(1, "s")},
        actuators={"a": Actuator(2, "m")},
        estimators=[EKF("x", "P", predict=drive, noise=0.05, initial=((0.5, -0.5), 2.0), correct=[measurement])],
        goals=[
            Goal("near", lambda x: (x**2).sum(-1)),
            Goal("far", lambda x: -x[..., 0]),
        ],
        dtype=torch.float64,
    )
    return Policy(model, Sum(), ActionLaw(0.1))


def test_without_a_reading_the_filter_predicts() -> None:
    policy = tracker()
    age = np.zeros(1)
    _, memory = policy.predict({"z": np.array([1.0, 1.0]), "age": age})
    for missing in (
        {"age": age},
        {"z": np.array([np.nan, np.nan]), "age": age},
        {"z": np.array([0.0, np.nan]), "age": age},
    ):
        action, after = policy.predict(missing, memory)
        torch.testing.assert_close(after["x"], drive(memory["x"], memory["a"]))
        torch.testing.assert_close(after["P"], memory["P"] + 0.05 * torch.eye(2, dtype=torch.float64))
        assert np.isfinite(action).all()
        assert all(value.isfinite().all() for value in after.values())
        _, again = policy.predict({"z": np.array([1.0, 1.0]), "age": age}, after)
        assert again["P"].diagonal().sum() < after["P"].diagonal().sum()


def test_an_episode_may_begin_without_a_reading() -> None:
    action, memory = tracker().predict({"age": np.zeros(1)})
    torch.testing.assert_close(memory["x"], torch.tensor([0.5, -0.5], dtype=torch.float64))
    assert np.isfinite(action).all()


def test_rows_miss_readings_alone() -> None:
    policy = tracker()
    z = np.array([[1.0, 1.0], [np.nan, 1.0], [2.0, 0.0]])
    age = np.zeros((3, 1))
    _, memory = policy.predict({"z": np.ones((3, 2)), "age": age})
    _, together = policy.predict({"z": z, "age": age}, memory)
    for row in range(3):
        one = {key: value[row] for key, value in memory.items()}
        _, alone = policy.predict({"z": z[row], "age": age[row]}, one)
        torch.testing.assert_close(alone["x"], together["x"][row])
        torch.testing.assert_close(alone["P"], together["P"][row])


def test_late_readings_count_less() -> None:
    """The noise is a function of the age of the reading."""

    def stale(age: Tensor) -> Tensor:
        return (0.1 + age) * torch.ones(2, dtype=age.dtype)

    policy = tracker(noise=stale)
    for age in (0.0, 0.4, 5.0):
        _, memory = policy.predict({"z": np.array([2.0, 1.0]), "age": np.array([age])})
        gain = 2.05 / (2.05 + 0.1 + age)
        expected = torch.tensor([0.5 + gain * 1.5, -0.5 + gain * 1.5], dtype=torch.float64)
        torch.testing.assert_close(memory["x"], expected)


def test_a_gated_filter_survives_a_missing_reading() -> None:
    policy = tracker(gate=9.0)
    age = np.zeros(1)
    _, memory = policy.predict({"z": np.array([1.0, 1.0]), "age": age})
    _, outlier = policy.predict({"z": np.array([1e6, 1e6]), "age": age}, memory)
    _, missing = policy.predict({"age": age}, memory)
    torch.testing.assert_close(outlier["x"], missing["x"])


# --- learned parts


class Learned(nn.Module):
    def __init__(self) -> None:
        super().__init__()
        self.scale = nn.Parameter(torch.tensor([0.1, 0.2], dtype=torch.float64))

    def forward(self, z: Tensor) -> Tensor:
        return self.scale**2 + 0.01 * z**2


def test_parameters_of_the_user_leave_no_graph_in_the_memory() -> None:
    model = WorldModel(
        sensors={"z": Sensor(2, "m")},
        actuators={"a": Actuator(2, "m")},
        estimators=[
            EKF(
                "x",
                "P",
                predict=drive,
                noise=Learned(),
                initial=((0.5, -0.5), 2.0),
                correct=[Measurement(seen, 1.0, size=2)],
            ),
            Deterministic("y", Interconnection(Learned(), inputs=("x",))),
        ],
        goals=[Goal("g", lambda x, y: (x * y).sum(-1))],
        dtype=torch.float64,
    )
    policy = Policy(model, Sum(), ActionLaw(0.1))
    _, memory = policy.predict({"z": np.ones(2)})
    _, memory = policy.predict({"z": np.ones(2)}, memory)
    assert not any(value.requires_grad for value in memory.values())
    assert len(list(policy.parameters())) == 2


# --- bad estimators


@pytest.mark.parametrize(
    ("make", "culprit"),
    [
        (lambda: Deterministic("x", lambda x: x), "'x' reads itself"),
        (
            lambda: EKF("x", "P", predict=lambda y: y, noise=1.0, initial=((0.0,), 1.0)),
            "'x' reads 'y'; it must read 'x'",
        ),
        (lambda: beacon(correct=[Measurement(lambda y, z: y - z, 1.0)]), "A measurement of 'x' reads 'y', 'z'"),
        (lambda: beacon(derivative="exact"), "'exact': expected 'model', 'update' or 'detached_gain'"),
        (lambda: beacon(initial=lambda z: (z, z)), "'x': .*size="),
        (lambda: beacon(noise=(1.0, 2.0, 3.0)), "noise"),
        (lambda: beacon(initial=((0.0, 0.0), (1.0, 1.0, 1.0))), "noise|variance"),
        (
            lambda: KalmanFilter("x", "P", predict=drive, noise=1.0, initial=((0.0,), 1.0)),  # type: ignore[arg-type]
            "'x': prediction and measurements must be Affine",
        ),
    ],
)
def test_a_bad_estimator_is_named(make: Any, culprit: str) -> None:
    with pytest.raises(GraphError, match=culprit):
        make()
