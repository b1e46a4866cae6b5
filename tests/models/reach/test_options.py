"""Wrong options of reaching are errors that say what would be right."""

import pytest
import torch
from _inputs.reaching import planar_arm, shift

from aicon_torch import make_policy, presets
from aicon_torch.errors import OptionError
from aicon_torch.models.reach import Robot
from aicon_torch.parts import Chain, Joint


def test_a_robot_is_needed() -> None:
    with pytest.raises(OptionError, match="robot=None: expected a URDF"):
        make_policy("reach")


def test_a_robot_without_speeds_needs_one() -> None:
    chain = Chain([shift(), shift(0.3)], shift(0.3), [Joint("shoulder"), Joint("elbow")])
    with pytest.raises(OptionError, match="speed=None: .*for 'shoulder', 'elbow'; .*or speed="):
        make_policy("reach", robot=Robot(chain))
    assert make_policy("reach", robot=Robot(chain), speed=1.0).model.actuators["a"].limit == (1, 1)


def test_a_joint_that_may_not_move_is_named() -> None:
    told = "'joint_1', .* have the largest speed 0 .* velocity= above 0"
    for speed in (None, 1.0):
        with pytest.raises(OptionError, match=told):
            make_policy("reach", robot=planar_arm(speed=0.0), speed=speed)


def test_balls_are_kept_from_a_shape() -> None:
    with pytest.raises(OptionError, match="balls=1: expected 0, since the robot has no shape"):
        make_policy("reach", robot=planar_arm(shape=False), balls=1)


@pytest.mark.parametrize(
    ("option", "value", "message"),
    [
        ("orientation", "round", "orientation='round': expected one of 'free', 'axis'"),
        ("dt", 0.0, "dt=0.0: expected a positive number"),
        ("tolerance", -1.0, "tolerance=-1.0: expected a number >= 0"),
        ("speed", -1.0, "speed=-1.0: expected a positive number"),
    ],
)
def test_a_wrong_value_is_named(option: str, value: object, message: str) -> None:
    with pytest.raises(OptionError, match=message):
        make_policy("reach", robot=planar_arm(), **{option: value})


@pytest.mark.parametrize("preset", presets("reach"))
def test_every_preset_acts(preset: str) -> None:
    robot = planar_arm()
    policy = make_policy("reach", preset=preset, robot=robot)
    observation = {"q": torch.full((3,), 0.4), "target_position": torch.tensor([0.2, 0.5, 0.0])}
    action, _ = policy.predict(observation)
    assert action.shape == (3,)
    assert action.abs().max() > 0


def test_one_robot_serves_several_policies() -> None:
    robot = planar_arm()
    first, second = (make_policy("reach", robot=robot, dtype=dtype) for dtype in _DTYPES)
    assert first.model.like.dtype == torch.float32
    assert second.model.like.dtype == torch.float64
    assert robot.chain.low.dtype == torch.float64


_DTYPES = (torch.float32, torch.float64)
