"""What is no observation, no action or no option of an arm is refused, by its name."""

from typing import Any

import pytest

pytest.importorskip("lerobot")
pytest.importorskip("mujoco")
pytest.importorskip("lerobot_robot_aicon")

import numpy as np
from _so101 import to_action
from lerobot.processor.core import TransitionKey

from lerobot_robot_aicon import (
    AiconShield,
    AiconShieldConfig,
    AiconSimulated,
    AiconSimulatedConfig,
    EndEffectorStep,
    ShieldStep,
)

pytestmark = pytest.mark.slow

STANDING = to_action([0.0, -90.0, 80.0, 10.0, 0.0])
POSE = {f"ee.{name}": 0.1 for name in ("x", "y", "z", "wx", "wy", "wz")}


@pytest.fixture(scope="module")
def robot() -> AiconShield:
    robot = AiconShield(AiconShieldConfig(inner=AiconSimulatedConfig(), urdf="so101", table=0.0))
    robot.connect()
    return robot


@pytest.fixture(scope="module")
def steps() -> dict[str, Any]:
    """Each step with an action that it takes."""
    return {
        "shield": (ShieldStep(urdf="so101", table=0.0), STANDING),
        "pose": (EndEffectorStep(urdf="so101", orientation="axis"), POSE),
    }


@pytest.mark.parametrize("name", ["shield", "pose"])
@pytest.mark.parametrize(
    ("observation", "message"),
    [
        (None, r"observation: expected a dict of numbers by shoulder_pan\.pos, .*, got NoneType"),
        ({}, r"observation: it has no shoulder_pan\.pos, .*; expected shoulder_pan\.pos"),
        ({**STANDING, "elbow_flex.pos": None}, r"elbow_flex\.pos is None; expected a number"),
        ({**STANDING, "elbow_flex.pos": "up"}, r"elbow_flex\.pos is 'up'; expected a number"),
    ],
)
def test_an_observation_without_all_motors_is_refused(
    steps: dict[str, Any], name: str, observation: Any, message: str
) -> None:
    step, action = steps[name]
    with pytest.raises(ValueError, match=message):
        step({TransitionKey.OBSERVATION: observation, TransitionKey.ACTION: action})
    with pytest.raises(ValueError, match=r"observation: expected a dict"):
        step({TransitionKey.ACTION: action})


@pytest.mark.parametrize("value", [None, "up", [1.0, 2.0]])
def test_an_action_of_no_number_is_refused(
    robot: AiconShield, steps: dict[str, Any], value: Any
) -> None:
    with pytest.raises(ValueError, match=r"action: shoulder_pan\.pos is .*; expected a number"):
        robot.send_action({"shoulder_pan.pos": value})

    step, action = steps["pose"]
    for key in ("ee.wz", "ee.gripper_pos"):
        transition = {TransitionKey.OBSERVATION: STANDING, TransitionKey.ACTION: action}
        with pytest.raises(ValueError, match=rf"action: {key} is .*; expected a number"):
            step({**transition, TransitionKey.ACTION: {**action, key: value}})


def test_what_is_no_action_is_refused(robot: AiconShield) -> None:
    nothing: Any = None
    with pytest.raises(ValueError, match=r"action: expected a dict of numbers by shoulder_pan"):
        robot.send_action(nothing)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"lead": -5.0}, r"lead=-5\.0: expected a number >= 0"),
        ({"lead": np.nan}, "lead=nan: expected 1 finite number"),
        ({"table": np.nan}, "table=nan: expected 1 finite number"),
        ({"offsets": {"elbow_flex": np.nan}}, r"offsets\['elbow_flex'\]=nan: expected 1 finite"),
        ({"fps": 0}, "fps=0: expected a positive number"),
        ({"speed": 0.0}, r"speed=0\.0: expected a positive number"),
        ({"speed": np.nan}, "speed=nan: expected 1 finite number"),
    ],
)
def test_an_option_that_cannot_be_is_named(options: dict[str, Any], message: str) -> None:
    config = AiconShieldConfig(inner=AiconSimulatedConfig(), urdf="so101", **options)
    with pytest.raises(ValueError, match=message):
        AiconShield(config)
    if "table" not in options:
        with pytest.raises(ValueError, match=message):
            EndEffectorStep(urdf="so101", **options)


def test_a_simulated_arm_takes_actions_some_times_a_second() -> None:
    with pytest.raises(ValueError, match="fps=0: expected a positive number"):
        AiconSimulated(AiconSimulatedConfig(fps=0))
