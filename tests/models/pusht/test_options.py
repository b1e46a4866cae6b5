"""Options and presets of the pushing policy, and what its action is."""

import math
from typing import Any

import pytest
import torch
from _asserts import rollout
from _inputs.pushing import wandering

from aicon_torch import DirectDescent, OptionError, make_policy
from aicon_torch.models import presets, pusht, replace_options
from aicon_torch.models.pusht import PIXEL
from aicon_torch.parts import Servo

PRESETS = presets("pusht")


@pytest.mark.parametrize("preset", PRESETS)
def test_every_preset_builds_and_acts(preset: str) -> None:
    policy = make_policy("pusht", preset=preset)
    for memory in rollout(policy, wandering(3, 2)):
        for name, value in memory.items():
            assert value.isfinite().all(), name
            assert not value.requires_grad and value.shape[0] == 2, name

    action, _ = policy.predict(wandering(1, 2)[0])
    assert action.shape == (2, 2)
    assert ((action >= 0.0) & (action <= 512.0)).all()  # px


def test_the_default_is_aicon_and_each_preset_is_another() -> None:
    assert PRESETS[0] == "aicon" and not pusht.PRESETS["aicon"]
    settings = [replace_options(pusht.Options(), pusht.PRESETS[preset]) for preset in PRESETS]
    for index, setting in enumerate(settings):
        assert setting not in settings[:index]


NOT_POSITIVE = (0.0, -1.0, math.nan, math.inf, "a")
POSITIVE = ("dt", "max_speed", "keypoint_noise")
BAD: list[tuple[dict[str, Any], str]] = [
    *(({name: value}, f"{name}={value!r}") for name in POSITIVE for value in NOT_POSITIVE),
    *(({"dt": value}, f"dt={value}.*0.01") for value in (0.005, 0.015)),
    *(({"delay": value}, f"delay={value}") for value in (-1, 1.0, True)),
    *(
        ({"goal_pose": value}, "goal_pose")
        for value in ((1.0, 2.0), 3.0, "abc", (math.nan, 0.0, 0.0), (0.0, math.inf, 0.0))
    ),
    ({"command": "best"}, "command='best'.*'position', 'velocity'"),
    ({"contact.reach": 0.0}, "reach=0.0"),
    ({"contact.effect": "best"}, "effect='best'.*'quasi_static', 'angle'"),
    ({"resolution.projector": "best"}, "projector='best'"),
    ({"resolution.temperature": 0.0}, "temperature"),
    ({"resolution.margin": -0.1}, "margin"),
    ({"resolution.exploration.opponent": "best"}, "opponent='best'"),
    ({"resolution.exploration.ratio_of": "best"}, "ratio_of='best'"),
    ({"resolution.exploration.enter_cosine": -0.1}, "enter_cosine"),
    ({"resolution.exploration.ratio": 0.5}, "ratio"),
    ({"resolution.exploration.average_time": 0.0}, "average_time"),
    ({"law.step": 0.0}, "step=0.0"),
    ({"law.iterations": 0}, "iterations=0"),
    ({"law.gain": 1.0}, "'law' of 'pusht' has no option 'gain'.*'iterations', 'step'"),
    ({"law.smoothing": -1.0}, "smoothing"),
    ({"speed": 1.0}, "'pusht' has no option 'speed'.*'goal_pose'.*'max_speed'"),
    ({"contact.speed": 1.0}, "'contact' of 'pusht' has no option 'speed'.*'size'.*'reach'"),
    ({"preset": "best"}, "no preset 'best'.*'aicon', 'paper_literal', 'steepest'"),
    ({"contact_limits": None}, "'pusht' has no option 'contact_limits'"),
]


@pytest.mark.parametrize(("options", "culprit"), BAD, ids=[str(options) for options, _ in BAD])
def test_a_bad_option_is_named(options: dict[str, Any], culprit: str) -> None:
    with pytest.raises(OptionError, match=culprit):
        make_policy("pusht", **options)


def test_the_action_is_a_target_or_a_velocity() -> None:
    """The same memory; the target leads the velocity by the controller's lag, or not at all."""
    (reading,) = wandering(1, 5)
    law = DirectDescent()  # foresight would see the controller, and act otherwise without it
    leading, memory = make_policy("pusht", law=law).predict(reading)
    lagging, second = make_policy("pusht", law=law, compensate_lag=False).predict(reading)
    velocity, third = make_policy("pusht", law=law, command="velocity").predict(reading)
    for other in (second, third):
        torch.testing.assert_close(other["a"], memory["a"])

    torch.testing.assert_close(velocity, memory["a"] / PIXEL)
    plain = (memory["x_pusher"] + 0.1 * memory["a"]) / PIXEL
    torch.testing.assert_close(lagging, plain.clamp(0.0, 512.0))
    share = Servo.of().displacement_by_offset[-1]
    lead = (memory["x_pusher"] + 0.1 * memory["a"] / share) / PIXEL
    torch.testing.assert_close(leading, lead.clamp(0.0, 512.0))
