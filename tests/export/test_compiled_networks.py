"""A network in the graph compiles, and what does not is told once, by its name."""

import logging

import pytest
import torch
from _asserts import assert_same_steps
from _inputs import MOVE, normal, tracked_point, tracking_model
from torch import Tensor, nn

from aicon_torch import Actuator, DirectDescent, Goal, Measurement, Policy, Sum
from aicon_torch.export import inductor
from aicon_torch.export.codegen import has_compiler

pytestmark = pytest.mark.skipif(not has_compiler(), reason="there is no C compiler")

LAYERS = (nn.GELU(), nn.ELU(), nn.LeakyReLU(), nn.ReLU6(), nn.LayerNorm(6), nn.BatchNorm1d(6))


class Seen(nn.Module):
    """A residual in which a network corrects what is read."""

    def __init__(self, *layers: nn.Module) -> None:
        super().__init__()
        self.layers = nn.Sequential(nn.Linear(4, 6), *layers, nn.Linear(6, 2))

    def forward(self, p: Tensor, z: Tensor) -> Tensor:
        return p - z - 0.1 * self.layers(torch.cat((p, z), dim=-1))


class Far(nn.Module):
    """A cost that a network tells."""

    def __init__(self, *layers: nn.Module) -> None:
        super().__init__()
        self.layers = nn.Sequential(nn.Linear(2, 6), *layers, nn.Linear(6, 1), nn.Softplus())

    def forward(self, p: Tensor) -> Tensor:
        return p.square().sum(-1) + 0.1 * self.layers(p)[..., 0]


def warnings_in(caplog: pytest.LogCaptureFixture) -> list[str]:
    """What the library warns of."""
    return [
        record.message
        for record in caplog.records
        if record.name.startswith("aicon_torch") and record.levelno == logging.WARNING
    ]


def seeing(*layers: nn.Module) -> Policy:
    """A point that a network sees, and its distance that a network tells."""
    torch.manual_seed(0)
    point = tracked_point(correct=[Measurement(Seen(*layers).eval(), 0.1, size=2)])
    model = tracking_model(
        MOVE,
        point,
        goals=[Goal("near", Far(*layers).eval())],
        actuators={"a": Actuator(2, "m/s", limit=1.0)},
    )
    return Policy(model, Sum(), DirectDescent(gain=1.0))


def test_networks_take_the_same_steps_in_c(caplog: pytest.LogCaptureFixture) -> None:
    policy = seeing(*LAYERS)
    readings = [{"z": 2.0 + normal(2, seed=seed)} for seed in range(8)]
    assert_same_steps(policy, policy.compile(), readings)
    assert warnings_in(caplog) == []


def test_an_operation_without_a_translation_is_told_once_by_its_name(
    caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuses(*_: object) -> None:
        raise RuntimeError("this takes minutes")

    monkeypatch.setattr(inductor, "_compile_step", refuses)
    policy = seeing(nn.Softshrink()).compile()
    memory = None
    with pytest.warns(RuntimeWarning, match="runs uncompiled"):
        for seed in range(3):
            _, memory = policy.predict({"z": normal(2, seed=seed)}, memory)

    (told,) = warnings_in(caplog)
    assert "'softshrink_backward'" in told and "TorchInductor" in told
