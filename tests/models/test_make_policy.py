"""Policies by name: presets, options, and errors that list the valid ones."""

import dataclasses
import subprocess
import sys
from typing import Any

import pytest
import torch
from _inputs import drifting

from aicon_torch import GraphError, NullspaceProjection, OptionError, SteepestPath, Sum, make_policy
from aicon_torch.models import nav2d as navigation, presets


@pytest.mark.parametrize("preset", presets("nav2d"))
def test_every_preset_builds_and_acts(preset: str) -> None:
    action, _ = make_policy("nav2d", preset=preset).predict(drifting(1)[0])
    assert action.shape == (2,) and action.isfinite().all()
    assert set(navigation.PRESETS[preset]) <= {field.name for field in dataclasses.fields(navigation.Options)}


def test_the_default_is_aicon() -> None:
    assert presets("nav2d")[0] == "aicon"
    assert {"aicon", "paper_literal", "steepest", "potential_field"} <= set(presets("nav2d"))
    assert not navigation.PRESETS["aicon"]


def test_presets_choose_the_rule() -> None:
    rules = {
        "aicon": NullspaceProjection,
        "paper_literal": NullspaceProjection,
        "steepest": SteepestPath,
        "potential_field": Sum,
    }
    for preset, rule in rules.items():
        assert isinstance(make_policy("nav2d", preset=preset).resolution, rule)


def test_options_override_the_preset() -> None:
    policy: Any = make_policy("nav2d", preset="paper_literal", temperature=0.5, accumulate=False, margin=0.2)
    assert (policy.resolution.temperature, policy.resolution.margin, policy.law.accumulate) == (0.5, 0.2, False)
    assert make_policy("nav2d", max_speed=0.3).model.actuators["a"].limit == 0.3
    assert make_policy("nav2d", dtype=torch.float32).model.like.dtype == torch.float32
    assert make_policy("nav2d", dt=0.1).model.dt == 0.1


def test_range_bearing_reads_one_more_sensor() -> None:
    policy = make_policy("nav2d", sensing="range_bearing")
    assert [sensor.key for sensor in policy.model.sensors.values()] == ["bearing", "range", "obstacle_bearing"]
    reading = drifting(1)[0] | {"obstacle_bearing": torch.tensor([1.0], dtype=torch.float64)}
    _, memory = policy.predict(reading)
    assert memory["x_obs"][1:] @ torch.tensor([1.0, 1.5]).double() < -0.3  # ∇d points away from the obstacle


@pytest.mark.parametrize(
    ("name", "options", "culprit"),
    [
        ("nav3d", {}, r"'nav3d'. Models: 'nav2d'"),
        ("nav2d", {"preset": "best"}, r"no preset 'best'. Presets: 'aicon', 'paper_literal'"),
        ("nav2d", {"speed": 1.0}, r"no option 'speed'. Options: .*'max_speed'.*'sensing'"),
        ("nav2d", {"sensing": "sonar"}, r"'sonar'.*'range' or 'range_bearing'"),
        ("nav2d", {"resolution": "average"}, r"'average'.*'nullspace', 'sum' or 'steepest'"),
        ("nav2d", {"projector": "svd"}, r"'svd'.*'orthogonal', 'qr', 'pinv', 'none'"),
        ("nav2d", {"temperature": 0.0}, "temperature"),
        ("nav2d", {"enter_cosine": -0.1}, "enter_cosine"),
        ("nav2d", {"gain": -1.0}, "gain"),
    ],
)
def test_what_is_unknown_is_named_and_what_is_valid_is_listed(name: str, options: dict[str, Any], culprit: str) -> None:
    with pytest.raises(OptionError, match=culprit):
        make_policy(name, **options)


@pytest.mark.parametrize("option", ["dt", "max_speed", "bearing_noise", "prior_range", "collision_length"])
@pytest.mark.parametrize("value", [0.0, -1.0, float("nan"), float("inf")])
def test_a_constant_that_cannot_be_is_named(option: str, value: float) -> None:
    with pytest.raises(OptionError, match=f"{option}={value}"):
        make_policy("nav2d", **{option: value})


def test_the_errors_are_value_errors_of_the_library() -> None:
    from aicon_torch import AiconError, ObservationError

    for error in (GraphError, ObservationError, OptionError):
        assert issubclass(error, AiconError) and issubclass(error, ValueError)


def test_importing_the_library_loads_torch_and_numpy_only() -> None:
    code = (
        "import sys, aicon_torch\n"
        "aicon_torch.make_policy('nav2d')\n"
        "others = {'gymnasium', 'shapely', 'scipy', 'stable_baselines3', 'aicon_envs', 'aicon_baselines', 'joblib'}\n"
        "sys.exit(', '.join(sorted(others & set(sys.modules))) or None)"
    )
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
