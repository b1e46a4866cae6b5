"""Options of a wrong kind are named before anything is built of them."""

import re
from typing import Any

import pytest
import torch
from _inputs.reaching import planar_arm

from aicon_torch import Actuator, OptionError, Policy, make_policy
from aicon_torch.dampers import VelocityDampers
from aicon_torch.errors import AiconError


@pytest.mark.parametrize(
    "option",
    [
        {"self_collision": 0.01},
        {"joint_limits": 5.0},
        {"balls": 1.5},
        {"obstacles": 2.5},
        {"turns_within": "a"},
        {"resolution": "sum"},
        {"dtype": "float32"},
        {"dampers.escape": "none"},
    ],
    ids=str,
)
def test_an_option_of_a_wrong_kind_is_named(option: dict[str, Any]) -> None:
    (name,) = option
    with pytest.raises(AiconError, match=f"{name.removeprefix('dampers.')}="):
        make_policy("reach", robot=planar_arm(), **option)


FLAGS = {
    "nav2d": ["watchdog"],
    "reach": ["watchdog", "safety"],
    "arm_push": ["watchdog", "touch", "camera.background"],
    "pusht": [
        *("watchdog", "observe_goal", "compensate_lag"),
        *("estimation", "likelihood_path", "position_path"),
    ],
}


@pytest.mark.parametrize("value", [None, "off", 0, 0.5])
@pytest.mark.parametrize(("model", "names"), FLAGS.items(), ids=FLAGS.keys())
def test_what_is_on_or_off_is_true_or_false(model: str, names: list[str], value: Any) -> None:
    for name in names:
        told = f"{name.removeprefix('camera.')}={value!r}: expected True or False"
        with pytest.raises(OptionError, match=re.escape(told)):
            make_policy(model, **{name: value})


@pytest.mark.parametrize(
    ("model", "option"),
    [
        ("pusht", {"contact": None}),
        ("pusht", {"picture": 3}),
        ("reach", {"axis": 3.0}),
        ("reach", {"axis": "z"}),
        ("arm_push", {"contact": 0.2}),
        ("arm_push", {"camera": None}),
        ("arm_push", {"law": None}),
        ("arm_push", {"upright_tolerance": "a"}),
        ("arm_push", {"expected_place": (0.5,)}),
    ],
    ids=str,
)
def test_a_part_of_a_wrong_kind_is_named(model: str, option: dict[str, Any]) -> None:
    (name,) = option
    with pytest.raises(OptionError, match=f"{name}="):
        make_policy(model, **option)


@pytest.mark.parametrize("dampers", [None, 0.2])
def test_dampers_of_an_actuator_are_dampers(dampers: Any) -> None:
    with pytest.raises(AiconError, match="dampers=.*: expected VelocityDampers"):
        Actuator(2, "rad/s", limit=1.0, dampers=dampers)


def test_an_escape_is_one() -> None:
    with pytest.raises(AiconError, match="escape=0.3: expected PlaceEscape"):
        VelocityDampers(escape=0.3)  # type: ignore[arg-type]


def test_a_resolution_is_one() -> None:
    model = make_policy("reach", robot=planar_arm()).model
    with pytest.raises(AiconError, match="resolution='sum': expected Resolution"):
        Policy(model, "sum")  # type: ignore[arg-type]


def test_a_memory_of_another_size_is_no_other_batch() -> None:
    policy = make_policy("reach", robot=planar_arm())
    q, target = torch.zeros(3), torch.zeros(3)
    seen = {"q": q, "target_position": target}
    _, memory = policy.predict(seen)
    memory["x_joints"] = torch.zeros(7)
    with pytest.raises(AiconError, match=r"state: expected shape \(3,\) of 'x_joints', got \(7,\)"):
        policy.predict(seen, memory)
