"""Wheel odometry: a filtered velocity that is a motion itself."""

import pytest
import torch
from _inputs import quick
from torch import Tensor

from aicon_torch import (
    Actuator,
    Affine,
    Deterministic,
    Goal,
    KalmanFilter,
    Measurement,
    Policy,
    Sensor,
    WorldModel,
)

DT = 0.1


def moved(v: Tensor, dt: float) -> Tensor:
    return v * dt


def apart(target: Tensor) -> Tensor:
    return target.norm(dim=-1)


def opposed(v: Tensor) -> Tensor:
    return v.norm(dim=-1)


def odometry(**options: bool) -> KalmanFilter:
    agreement = Measurement(Affine(v=1.0, z_wheel=-1.0), noise=0.01**2, size=2)
    return KalmanFilter(
        "v",
        "P_v",
        predict=Affine(v=0.0, a=1.0),
        noise=0.1**2,
        initial=((0.0, 0.0), 0.1**2),
        correct=[agreement],
        **options,
    )


def policy_with(wheels: KalmanFilter) -> Policy:
    """It approaches a target and would rather stand: two gradients meet at its velocity."""
    seen = Measurement(Affine(target=1.0, z_target=-1.0), noise=0.05**2, size=2)
    target = KalmanFilter(
        "target",
        "P_target",
        predict=Affine(target=1.0, x=-1.0),
        noise=1e-4,
        initial=((3.0, 0.0), 1.0),
        correct=[seen],
    )

    model = WorldModel(
        sensors={"z_wheel": Sensor(2, "m/s", optional=True), "z_target": Sensor(2, "m")},
        actuators={"a": Actuator(2, "m/s", limit=1.0)},
        estimators=[wheels, Deterministic("x", moved, is_motion=True), target],
        goals=[Goal("approach", apart), Goal("stand", opposed)],
        dt=DT,
        dtype=torch.float64,
    )
    return Policy(model)


def test_the_wheels_say_how_fast_it_was_and_the_model_how_it_can_be_changed() -> None:
    policy = policy_with(odometry(is_motion=True))
    _, memory = policy.predict({"z_wheel": [0.3, 0.0], "z_target": [3.0, 0.0]})

    values = policy.trace(memory).values
    torch.testing.assert_close(values["v"], torch.tensor([0.3, 0.0]).double(), atol=0.01, rtol=0)
    torch.testing.assert_close(values["x"], values["v"] * DT)
    paths = {str(path) for path in policy.model.paths()}
    assert paths == {"approach → target → x → v → a", "stand → v → a"}


@pytest.mark.parametrize("is_motion", [True, False])
def test_what_is_a_motion_is_averaged_as_it_is(is_motion: bool) -> None:
    """Of another quantity it is the change that counts, which at a constant speed is none."""
    policy = quick(policy_with(odometry(is_motion=is_motion)))
    assert policy.model.quantities["v"].is_motion == is_motion

    memory = None
    for _ in range(100):
        _, memory = policy.predict({"z_wheel": [0.3, 0.0], "z_target": [3.0, 0.0]}, memory)
    average = memory["v/average"][0] if memory else torch.tensor(torch.nan)
    assert float(average) == pytest.approx(0.3 if is_motion else 0.0, abs=0.02)
