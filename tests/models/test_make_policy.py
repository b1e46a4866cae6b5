"""Policies by name: presets, options, and errors that list the valid ones."""

import subprocess
import sys
from typing import Any

import pytest
import torch

from aicon_torch import (
    AiconError,
    DirectDescent,
    Foresight,
    GraphError,
    NullspaceProjection,
    ObservationError,
    OptionError,
    SteepestPath,
    Sum,
    make_policy,
)
from aicon_torch.models import presets

MODELS = ("nav2d", "pusht")
RULES = {
    "aicon": NullspaceProjection,
    "paper_literal": NullspaceProjection,
    "steepest": SteepestPath,
    "potential_field": Sum,
}


@pytest.mark.parametrize("name", MODELS)
def test_the_default_is_aicon(name: str) -> None:
    assert presets(name)[0] == "aicon"
    assert set(RULES) <= set(presets(name))

    policy, default = make_policy(name, preset="aicon"), make_policy(name)
    assert (policy.resolution, policy.law) == (default.resolution, default.law)


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.parametrize(("preset", "rule"), RULES.items())
def test_presets_choose_the_rule(name: str, preset: str, rule: type) -> None:
    assert isinstance(make_policy(name, preset=preset).resolution, rule)


def test_options_override_the_preset() -> None:
    changes = {"resolution.temperature": 0.5, "resolution.margin": 0.2, "law.accumulate": False}
    policy: Any = make_policy("nav2d", preset="paper_literal", **changes)
    assert (policy.resolution.temperature, policy.resolution.margin) == (0.5, 0.2)
    assert policy.law.gain == 10.0 and not policy.law.accumulate

    assert make_policy("nav2d", max_speed=0.3).model.actuators["a"].limit == 0.3
    assert make_policy("nav2d", dtype=torch.float32).model.like.dtype == torch.float32
    assert make_policy("nav2d", dt=0.1).model.dt == 0.1


def test_a_whole_resolution_can_be_given() -> None:
    policy = make_policy("nav2d", resolution=Sum(), **{"law.step": 0.5})
    assert policy.resolution == Sum() and policy.law == Foresight(step=0.5)


def test_a_whole_law_can_be_given() -> None:
    law = DirectDescent(gain=3.0)
    assert make_policy("nav2d", law=law).law == law


@pytest.mark.parametrize(
    ("name", "options", "culprit"),
    [
        ("nav3d", {}, r"'nav3d'. Models: 'nav2d'"),
        ("nav2d", {"preset": "best"}, r"no preset 'best'. Presets: 'aicon', 'paper_literal'"),
        ("nav2d", {"speed": 1.0}, r"no option 'speed'. Options: .*'max_speed'.*'sensing'"),
        (
            "nav2d",
            {"law.speed": 1.0},
            r"'law' of 'nav2d' has no option 'speed'. Options: 'iterations'",
        ),
        ("nav2d", {"sensing": "sonar"}, r"'sonar'.*'range', 'range_bearing'"),
        ("nav2d", {"resolution.projector": "svd"}, r"'svd'.*'orthogonal', 'qr', 'pinv', 'none'"),
        ("nav2d", {"resolution.temperature": 0.0}, "temperature"),
        ("nav2d", {"resolution.exploration.enter_cosine": -0.1}, "enter_cosine"),
        ("nav2d", {"law.step": -1.0}, "step=-1.0"),
        ("nav2d", {"law.iterations": 0}, "iterations=0"),
    ],
)
def test_what_is_unknown_is_named_and_what_is_valid_is_listed(
    name: str, options: dict[str, Any], culprit: str
) -> None:
    with pytest.raises(OptionError, match=culprit):
        make_policy(name, **options)


def test_the_errors_are_value_errors_of_the_library() -> None:
    for error in (GraphError, ObservationError, OptionError):
        assert issubclass(error, AiconError) and issubclass(error, ValueError)


def test_importing_the_library_loads_torch_and_numpy_only() -> None:
    code = (
        "import sys, aicon_torch\n"
        f"for name in {MODELS}: aicon_torch.make_policy(name)\n"
        "others = {'gymnasium', 'shapely', 'scipy', 'stable_baselines3', 'aicon_envs',\n"
        "    'aicon_baselines', 'joblib'}\n"
        "sys.exit(', '.join(sorted(others & set(sys.modules))) or None)"
    )
    command = [sys.executable, "-c", code]
    result = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
    assert result.returncode == 0, result.stderr
