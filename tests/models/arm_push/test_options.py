import pytest
from _inputs import lean

from aicon_baselines import agents
from aicon_torch import NullspaceProjection, OptionError, SteepestPath, Sum, make_policy
from aicon_torch.models.arm_push import CameraOptions, Options

pytest.importorskip("gymnasium")

WIDE = ((-0.25, -0.25), (0.25, -0.25), (0.25, 0.25), (-0.25, 0.25))

UNSEEN = {
    "without_foresight",
    "without_friction",
    "without_inset",
    "without_ring",
    "without_touch",
}
"""Ablations that differ neither in their paths nor in the resolution."""


def test_the_presets_are_ours_and_the_baselines():
    resolutions = {"aicon": NullspaceProjection, "steepest": SteepestPath, "potential_field": Sum}
    for preset, kind in resolutions.items():
        policy = lean("arm_push", preset=preset, sensing="pose")
        assert type(policy.resolution) is kind


ABLATIONS = agents.ablations("arm_push")


@pytest.mark.parametrize("name", ABLATIONS)
def test_every_ablation_can_be_built_and_differs_from_ours(name):
    policy = make_policy("arm_push", **ABLATIONS[name])
    assert policy.model.paths()
    ours = lean("arm_push")
    if name.startswith("without_"):
        fewer = len(policy.model.paths()) < len(ours.model.paths())
        assert fewer or policy.resolution != ours.resolution or name in UNSEEN


def test_a_nested_option_is_named_by_its_path():
    policy = make_policy("arm_push", **{"camera.trace_weight": 7.0, "joint_limits.margin": 0.3})
    assert policy.model.goals["push"].cost.function.weight == 7.0
    assert policy.model.goals["joint_limits"].cost.function.cost.margin == 0.3


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"sensing": "touch"}, "sensing='touch': expected one of 'camera', 'pose'"),
        ({"pullback": "inverse"}, "pullback='inverse'"),
        ({"camera.steering": "zoom"}, "steering='zoom'"),
        ({"camera.noise": 0.0}, "noise=0.0: expected a positive number"),
        ({"goals": ("speed",)}, "has no option 'goals'"),
        ({"camera.speed": 1.0}, "'edge_growth'"),
        ({"corners": ((0.0, 0.0), (1.0, 0.0))}, "3 or more corners"),
        ({"stick_friction": -0.1}, "stick_friction=-0.1"),
        ({"corners": WIDE}, "gets nowhere around an object .* 0.354 m from its centre"),
    ],
)
def test_wrong_options_are_named(options, message):
    with pytest.raises(OptionError, match=message):
        make_policy("arm_push", **options)


def test_groups_check_themselves():
    with pytest.raises(OptionError, match="edge_growth=-1"):
        CameraOptions(edge_growth=-1)
    with pytest.raises(OptionError, match="lever"):
        Options(lever=0.0)
