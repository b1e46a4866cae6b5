"""A network in the graph compiles, and what does not is told once, by its name."""

import logging
from pathlib import Path

import pytest
import torch
from _asserts import assert_same_steps
from _inputs import MOVE, normal, tracked_point, tracking_model
from torch import Tensor, nn

from aicon_torch import (
    Actuator,
    DirectDescent,
    Goal,
    Interconnection,
    Measurement,
    Policy,
    Sensor,
    Sum,
)
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


def convolutions(inputs: int, outputs: int) -> nn.Sequential:
    """Layers of images of one and two dimensions, 27,000 weights."""
    layers = [
        *(nn.Linear(inputs, 144), nn.Unflatten(-1, (1, 144)), nn.Conv1d(1, 1, 5, padding=2)),
        *(nn.Unflatten(-1, (12, 12)), nn.Conv2d(1, 16, 3, padding=1), nn.ReLU()),
        *(nn.AvgPool2d(2), nn.Conv2d(16, 32, 3, padding=2, dilation=2), nn.LeakyReLU()),
        *(nn.Conv2d(32, 64, 3, stride=2, padding=1, groups=2), nn.GELU()),
        *(nn.BatchNorm2d(64), nn.Flatten(), nn.LayerNorm(576), nn.Linear(576, 24), nn.Tanh()),
        nn.Linear(24, outputs),
    ]
    return nn.Sequential(*layers)


class SeenInImage(nn.Module):
    """A residual that a convolution corrects."""

    def __init__(self) -> None:
        super().__init__()
        self.layers = convolutions(4, 2)

    def forward(self, p: Tensor, z: Tensor) -> Tensor:
        return p - z - 0.1 * self.layers(torch.cat((z, z), dim=-1))


def with_unit_slope(network: nn.Module) -> Interconnection:
    """A residual p − f(z), whose Jacobian by p is given."""
    return Interconnection(network.eval(), p=lambda p: torch.eye(2, dtype=p.dtype))


class FarInImage(nn.Module):
    """A cost through a convolution, which is differentiated."""

    def __init__(self) -> None:
        super().__init__()
        layers = (nn.Linear(2, 36), nn.Unflatten(-1, (1, 6, 6)), nn.Conv2d(1, 2, 3, padding=1))
        self.layers = nn.Sequential(*layers, nn.Tanh(), nn.Flatten(), nn.Linear(72, 1))

    def forward(self, p: Tensor) -> Tensor:
        return p.square().sum(-1) + 0.1 * self.layers(p)[..., 0]


def test_the_gradient_of_a_convolution_is_a_loop_in_c(tmp_path: Path) -> None:
    torch.manual_seed(0)
    goals = [Goal("near", FarInImage().eval())]
    policy = Policy(tracking_model(MOVE, tracked_point(), goals=goals), Sum(), DirectDescent(1.0))
    policy.export(tmp_path / "policy.c")
    assert "  convolve_back(" in (tmp_path / "policy.c").read_text()
    readings = [{"z": 2.0 + normal(2, seed=seed)} for seed in range(4)]
    assert_same_steps(policy, policy.compile(), readings)


def test_convolutions_are_loops_in_c(caplog: pytest.LogCaptureFixture, tmp_path: Path) -> None:
    torch.manual_seed(0)
    point = tracked_point(correct=[Measurement(with_unit_slope(SeenInImage()), 0.1, size=2)])
    policy = Policy(tracking_model(MOVE, point), Sum(), DirectDescent(gain=1.0))
    policy.export(tmp_path / "policy.c")
    source = (tmp_path / "policy.c").read_text()
    assert "convolve(" in source
    assert len(source.splitlines()) < 20_000  # not a line for each of 27,000 weights and more

    readings = [{"z": 2.0 + normal(2, seed=seed)} for seed in range(4)]
    assert_same_steps(policy, policy.compile(), readings)
    assert warnings_in(caplog) == []


class SeenInPicture(nn.Module):
    """A residual that is read off a picture, whose colours come last."""

    def __init__(self) -> None:
        super().__init__()
        convolution = nn.Conv2d(3, 6, 3, stride=2, padding=1)
        self.layers = nn.Sequential(convolution, nn.ReLU(), nn.Flatten(), nn.Linear(486, 2))

    def forward(self, p: Tensor, z: Tensor) -> Tensor:
        pictures = z.unflatten(-1, (17, 17, 3)).movedim(-1, -3)
        share = pictures.flatten(-2).softmax(-1).amax(-1)
        return p - self.layers(pictures / 255) + share[..., :2]


def test_a_picture_that_may_be_missing_is_loops_in_c(
    caplog: pytest.LogCaptureFixture, tmp_path: Path
) -> None:
    torch.manual_seed(0)
    size = 17 * 17 * 3
    point = tracked_point(correct=[Measurement(with_unit_slope(SeenInPicture()), 0.1, size=2)])
    sensors = {"z": Sensor(size, "grey levels", optional=True, range=(-1e3, 1e3))}
    policy = Policy(tracking_model(MOVE, point, sensors=sensors), Sum(), DirectDescent(gain=1.0))
    policy.export(tmp_path / "policy.c")
    assert len((tmp_path / "policy.c").read_text().splitlines()) < 4 * size

    readings = [{"z": 9.0 * normal(size, seed=seed)} for seed in range(5)]
    readings[2]["z"][size - 1] = torch.nan
    assert_same_steps(policy, policy.compile(), readings)
    assert warnings_in(caplog) == []


class Largest(nn.Module):
    """What is largest in windows of a reading."""

    def __init__(self) -> None:
        super().__init__()
        layers = (nn.Linear(2, 64), nn.Unflatten(-1, (1, 8, 8)), nn.MaxPool2d(3, 2, 1))
        self.layers = nn.Sequential(*layers, nn.Flatten(), nn.Linear(16, 2))

    def forward(self, p: Tensor, z: Tensor) -> Tensor:
        return p - self.layers(z)


def test_what_is_largest_in_a_window_is_a_loop_in_c() -> None:
    torch.manual_seed(0)
    point = tracked_point(correct=[Measurement(with_unit_slope(Largest()), 0.1, size=2)])
    policy = Policy(tracking_model(MOVE, point), Sum(), DirectDescent(gain=1.0))
    readings = [{"z": normal(2, seed=seed)} for seed in range(4)]
    assert_same_steps(policy, policy.compile(), readings)


def test_an_operation_without_a_translation_is_told_once_by_its_name(
    caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuses(*_: object) -> None:
        raise RuntimeError("this takes minutes")

    monkeypatch.setattr(inductor, "compile_stages", refuses)
    policy = seeing(nn.Softshrink()).compile()
    memory = None
    with pytest.warns(RuntimeWarning, match="runs uncompiled"):
        for seed in range(3):
            _, memory = policy.predict({"z": normal(2, seed=seed)}, memory)

    (told,) = warnings_in(caplog)
    assert "'softshrink_backward'" in told and "TorchInductor" in told
