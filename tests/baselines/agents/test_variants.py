"""Variants of a policy, written as text."""

import pytest

from aicon_baselines.agents.variants import make_variants, parse_variant
from aicon_baselines.evaluation import ComparisonError
from aicon_baselines.tasks.nav2d import TASK
from aicon_torch import Policy


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("steepest", ("steepest", {})),
        ("max_speed=0.3", ("aicon", {"max_speed": 0.3})),
        (
            "resolution.temperature=None,law.step=0.5",
            ("aicon", {"resolution.temperature": None, "law.step": 0.5}),
        ),
        (
            "steepest, resolution.projector=oblique, law.accumulate=True",
            ("steepest", {"resolution.projector": "oblique", "law.accumulate": True}),
        ),
        ("goal=(1, 2),dt=0.1", ("aicon", {"goal": (1, 2), "dt": 0.1})),
    ],
)
def test_variants_are_read(text: str, expected: object) -> None:
    assert parse_variant(text) == expected


@pytest.mark.parametrize(
    "text",
    [
        "",
        "a,b",
        "a=1,a=2",
        "a={[]: 1}",
        "margin=",
        "margin=2*x",
        "margin=0.1)+f(",
        "*x",
        "law.=1",
        "law.step",
        "=1",
    ],
)
def test_what_is_no_variant_is_refused(text: str) -> None:
    message = "a variant is written 'policy', 'option=value,option=value'"
    with pytest.raises(ComparisonError, match=message):
        parse_variant(text)


def test_variants_are_built_with_their_options() -> None:
    policies = make_variants(TASK, "range", ["max_speed=0.3", "steepest,max_speed=0.4"])
    limits = {}
    for name, build in policies.items():
        policy = build("range_bearing")
        assert isinstance(policy, Policy) and "z_dir" in policy.model.sensors
        limits[name] = policy.model.actuators["a"].limit
    assert limits == {"aicon": 0.5, "max_speed=0.3": 0.3, "steepest,max_speed=0.4": 0.4}


def test_what_a_variant_names_wrongly_is_said_before_anything_runs() -> None:
    message = "variant 'no_such=1': 'nav2d' has no option 'no_such'. Options: "
    with pytest.raises(ComparisonError, match=message):
        make_variants(TASK, "range", ["no_such=1"])

    with pytest.raises(ComparisonError, match="resolution.no_such=1.*temperature"):
        make_variants(TASK, "range", ["resolution.no_such=1"])
    with pytest.raises(ComparisonError, match="unknown policy 'no_such' for task 'nav2d'"):
        make_variants(TASK, "range", ["no_such"])
