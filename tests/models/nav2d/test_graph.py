"""The navigation model's graph: the paper's three paths, and closed forms of their gradients."""

import math

import pytest
import torch
from _asserts import along, rollout
from _inputs import drifting, lean
from torch import Tensor

from aicon_torch import OptionError, make_policy
from aicon_torch.models import presets

MODEL = make_policy("nav2d").model
PATHS = {"reach → p_tar → x_rob → a", "reach → P_tar → x_rob → a", "avoid → x_obs → x_rob → a"}


@pytest.mark.parametrize("sensing", ["range", "range_bearing"])
def test_the_paths_are_the_paper_s(sensing: str) -> None:
    paths = make_policy("nav2d", sensing=sensing).model.paths()
    assert {str(path) for path in paths} == PATHS
    assert len(paths) == 3


def test_the_drawing_lists_every_node() -> None:
    drawn = MODEL.to_mermaid()
    for name in ("z_tar", "z_obs", "a", "x_rob", "p_tar", "P_tar", "x_obs", "P_obs"):
        assert name in drawn
    assert "reach" in drawn and "avoid" in drawn


def uncertainty(action: Tensor, start: dict[str, Tensor]) -> Tensor:
    """tr Σ of the target one step ahead, after another bearing from there, by hand."""
    mean = start["p_tar"] - start["x_rob"] - 0.05 * (action - start["a"])
    prior = start["P_tar"] + (0.02 * 0.05) ** 2 * torch.eye(2, dtype=torch.float64)
    h = torch.stack((-mean[1], mean[0])) / (mean @ mean)
    gain = prior @ h / (h @ prior @ h + 0.03**2)
    return (prior - torch.outer(gain, prior @ h)).trace()


def test_the_gradients_have_the_closed_forms_of_the_paper() -> None:
    """p₁ = −μ/‖μ‖, p₃ = ∇exp(−d/ℓ) = −exp(−d/ℓ)/ℓ·∇d, p₂ by finite differences; all times dt."""
    for memory in rollout(lean("nav2d"), drifting(60))[::10]:
        start = MODEL.values(memory)
        local = MODEL.record(start)
        slopes = {str(path): along(path, MODEL, local) for path in MODEL.paths()}

        p1 = -start["p_tar"] / start["p_tar"].norm()
        torch.testing.assert_close(slopes["reach → p_tar → x_rob → a"], 0.05 * p1)
        p3 = -torch.exp(-start["x_obs"][:1] / 0.04) / 0.04 * start["x_obs"][1:]
        torch.testing.assert_close(slopes["avoid → x_obs → x_rob → a"], 0.05 * p3)

        numeric = []
        for step in 1e-6 * torch.eye(2, dtype=torch.float64):
            ahead = uncertainty(start["a"] + step, start)
            behind = uncertainty(start["a"] - step, start)
            numeric.append((ahead - behind) / 2e-6)
        p2 = slopes["reach → P_tar → x_rob → a"]
        torch.testing.assert_close(p2, torch.stack(numeric), rtol=1e-4, atol=1e-8)


def test_the_obstacle_s_direction_is_learned_from_motion() -> None:
    """A wall at x = 2: the readings are one number, its direction comes from how it changes."""
    policy, position, memory = lean("nav2d"), torch.zeros(2, dtype=torch.float64), None
    for step in range(60):
        reading = {"bearing": torch.zeros(1, dtype=torch.float64), "range": 2.0 - position[:1]}
        circle = [0.4 * math.cos(step / 9), 0.4 * math.sin(step / 9)]
        executed = {"a": torch.tensor(circle, dtype=torch.float64)}
        memory = policy.estimate(reading, memory, executed)
        position = position + memory["x_rob"]

    assert memory is not None
    away = torch.tensor([-1.0, 0.0], dtype=torch.float64)
    torch.testing.assert_close(memory["x_obs"][1:], away, rtol=0, atol=0.25)
    clearance = 2.0 - position[:1] + memory["x_rob"][:1]
    torch.testing.assert_close(memory["x_obs"][:1], clearance, rtol=0, atol=0.02)


def test_with_a_second_bearing_the_direction_is_read() -> None:
    policy = make_policy("nav2d", sensing="range_bearing")
    keys = [sensor.key for sensor in policy.model.sensors.values()]
    assert keys == ["bearing", "range", "obstacle_bearing", "elapsed"]

    towards = torch.tensor([1.0], dtype=torch.float64)
    _, memory = policy.predict(drifting(1)[0] | {"obstacle_bearing": towards})
    obstacle = torch.tensor([math.cos(1.0), math.sin(1.0)], dtype=torch.float64)
    assert memory["x_obs"][1:] @ obstacle < -0.3  # ∇d points away from it


@pytest.mark.parametrize("preset", presets("nav2d"))
def test_every_preset_builds_and_acts(preset: str) -> None:
    action, _ = make_policy("nav2d", preset=preset).predict(drifting(1)[0])
    assert action.shape == (2,) and action.isfinite().all()


CONSTANTS = ("dt", "max_speed", "bearing_noise", "range_noise", "actuation_noise")


@pytest.mark.parametrize("option", CONSTANTS)
@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf])
def test_a_constant_that_cannot_be_is_named(option: str, value: float) -> None:
    with pytest.raises(OptionError, match=f"{option}={value}"):
        make_policy("nav2d", **{option: value})
