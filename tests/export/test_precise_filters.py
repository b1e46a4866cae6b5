"""A filter that takes a precise reading at its word is exported: what it rounds is not compared."""

from pathlib import Path

import pytest
import torch

from aicon_torch import (
    Actuator,
    Affine,
    Goal,
    KalmanFilter,
    Measurement,
    Policy,
    Sensor,
    WorldModel,
    load_exported,
)


def precise(noise: float) -> Policy:
    """A point that nothing is known of, and that is then read as precisely as that."""
    place = KalmanFilter(
        "x",
        "P",
        predict=Affine(x=1.0, v="dt"),
        noise=noise,
        initial=((1.0, 1.0), 9.0),
        correct=[Measurement(Affine(x=1.0, z=-1.0), noise, size=2)],
    )

    model = WorldModel(
        sensors={"z": Sensor(2, "m")},
        actuators={"v": Actuator(2, "m/s", limit=1.0)},
        estimators=[place],
        goals=[Goal("near", lambda x: x.norm(dim=-1))],
        dt=0.05,
        dtype=torch.float64,
    )
    return Policy(model)


@pytest.mark.parametrize("noise", [pytest.param(1e-4, marks=pytest.mark.slow), 1e-8, 1e-12])
def test_it_is_loaded_where_it_was_made_and_does_the_same(noise: float, tmp_path: Path) -> None:
    policy = precise(noise)
    policy.export(tmp_path / "policy.so")
    exported = load_exported(tmp_path / "policy.so")
    seen = {"z": torch.tensor([0.3, -0.4], dtype=torch.float64)}
    expected, _ = policy.predict(seen)
    action, _ = exported.predict({"z": seen["z"].numpy()})
    assert action == pytest.approx(expected.numpy(), abs=1e-6)
