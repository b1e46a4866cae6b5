"""Where an arm stands is known once two readings agree, on any turn, and is gone to in safety."""

import copy
from typing import Any

import numpy as np
import pytest
import torch
from numpy.typing import NDArray

pytest.importorskip("lerobot")
pytest.importorskip("mujoco")
pytest.importorskip("lerobot_robot_aicon")

from _so101 import arm, joints, to_action
from lerobot.processor.core import TransitionKey

from aicon_torch import Policy
from aicon_torch.parts import Chain
from lerobot_robot_aicon import (
    AiconShield,
    AiconShieldConfig,
    AiconSimulated,
    AiconSimulatedConfig,
    EndEffectorStep,
)
from lerobot_robot_aicon.arm_options import ShieldOptions
from lerobot_robot_aicon.commanded_joints import CommandedJoints
from lerobot_robot_aicon.joint_shield import WANTED

pytestmark = pytest.mark.slow

HOME = np.array([0.0, -90.0, 80.0, 10.0, 170.0])
LEAD = 10.0


def test_a_first_reading_that_is_wrong_moves_no_arm(monkeypatch: pytest.MonkeyPatch) -> None:
    config = AiconShieldConfig(inner=AiconSimulatedConfig(seed=3), urdf="so101", table=0.0)
    robot = AiconShield(config)
    robot.connect()
    before, look = robot.get_observation(), robot.inner.get_observation

    def show_once() -> dict[str, Any]:
        monkeypatch.setattr(robot.inner, "get_observation", look)
        return {**before, "shoulder_pan.pos": before["shoulder_pan.pos"] + 60.0}

    for _ in range(2):  # wrong in the first episode, and after it was connected again
        monkeypatch.setattr(robot.inner, "get_observation", show_once)
        robot.get_observation()
        assert robot.send_action(before) == {}
        assert robot.explain() is None
        for _ in range(10):
            robot.get_observation()
            sent = robot.send_action(before)
            assert not sent or joints(sent) == pytest.approx(joints(before), abs=0.01)
        assert sent
        robot.disconnect()
        robot.connect()


def test_readings_that_never_agree_move_no_arm_and_are_told(
    caplog: pytest.LogCaptureFixture,
) -> None:
    commanded = CommandedJoints(arm().chain, ShieldOptions(urdf="so101"))
    for t in range(6):
        shown = to_action([*HOME[:4], 60.0 * (t % 2)])
        assert commanded.look(shown).is_held
        assert commanded.stays() == {}
    assert "The arm is not moved: two readings in a row do not agree, wrist_roll.pos" in caplog.text


def test_a_motor_that_is_left_out_stays_where_it_was_sent() -> None:
    robot = AiconSimulated(AiconSimulatedConfig())
    robot.connect()
    with pytest.raises(ValueError, match=r"action: elbow_flex\.pos is None; expected a number"):
        robot.send_action({"elbow_flex.pos": None})
    robot.send_action(to_action([0.0, -60.0, 60.0, 0.0, 0.0]))
    for _ in range(60):
        robot.send_action({"shoulder_pan.pos": 20.0, "gripper.pos": 10.0})
        robot.send_action({"elbow_flex.pos": np.nan, "gripper.pos": np.nan})
    assert robot.get_observation()["gripper.pos"] == 10.0
    reached = np.degrees(joints(robot.get_observation()))
    assert reached == pytest.approx([20.0, -60.0, 60.0, 0.0, 0.0], abs=2.0)


@pytest.fixture
def endless() -> Chain:
    """SO-101, whose last joint has no stops."""
    chain = copy.deepcopy(arm().chain)
    chain.low[4], chain.high[4] = -torch.inf, torch.inf
    return chain


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("is_within_turn", [False, True])
def test_a_joint_without_stops_is_never_sent_a_turn_back(
    endless: Chain, sign: int, is_within_turn: bool
) -> None:
    options = ShieldOptions(urdf="so101", signs={"wrist_roll": sign}, offsets={"wrist_roll": 30.0})
    commanded = CommandedJoints(endless, options)
    q, shown = HOME.copy(), 0.0
    for t in range(400):
        shown = sign * q[4] + 30.0
        if is_within_turn:
            shown = (shown + 180.0) % 360.0 - 180.0
        state = commanded.look(to_action([*q[:4], shown]))
        assert state.is_held == (t == 0)
        assert not state.is_displaced

        velocity = np.array([0.0, 0.0, 0.0, 0.0, 1.5 if t < 250 else -1.5])
        sent = commanded.moved(state.commanded, velocity)["wrist_roll.pos"]
        assert abs(sent - shown) <= LEAD + 3.0
        q[4] += 0.5 * sign * (sent - shown)
    assert HOME[4] + 180.0 < q[4] < HOME[4] + 720.0


def test_a_motor_that_counts_within_one_turn_is_sent_the_shorter_way(endless: Chain) -> None:
    commanded = CommandedJoints(endless, ShieldOptions(urdf="so101"))
    for shown in (175.0, 175.0, 178.0, -178.0):
        state = commanded.look(to_action([*HOME[:4], shown]))
        commanded.moved(state.commanded, np.zeros(5))

    for told in (190.0, -170.0):  # the same place
        wanted = commanded.motors.told(to_action([*HOME[:4], told]), state.commanded)
        assert np.degrees(wanted)[4] == pytest.approx(190.0)


def test_a_joint_with_stops_is_not_taken_for_one_that_turns_on(endless: Chain) -> None:
    commanded = CommandedJoints(arm().chain, ShieldOptions(urdf="so101"))
    for shown in (150.0, 150.0, -165.0):
        state = commanded.look(to_action([*HOME[:4], shown]))
        commanded.moved(state.commanded, np.zeros(5))
    assert state.is_held


def test_on_the_way_after_an_arm_that_was_moved_links_do_not_touch(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The straight line between the two postures leads through the arm itself."""
    monkeypatch.setattr(Policy, "compile", lambda policy: policy)
    step = EndEffectorStep(urdf="ur5")
    here = np.array([116.0, 31.0, -8.0, -88.0, -154.0, -174.0])
    there = np.array([23.0, -72.0, -131.0, 159.0, -110.0, 106.0])
    halfway = [here + share * (there - here) for share in np.linspace(0.0, 1.0, 25)]
    assert min(gap_of_links(step, q) for q in halfway) < -0.03

    pose = {f"ee.{name}": 0.3 for name in ("x", "y", "z", "wx", "wy", "wz")}
    keys, arrived = step._joints.keys, False
    for t in range(150):
        shown = dict(zip(keys, here if t < 2 else there, strict=True))
        transition = {TransitionKey.OBSERVATION: shown, TransitionKey.ACTION: dict(pose)}
        action = step(transition)[TransitionKey.ACTION]
        if t > 0:
            sent = np.array([action[key] for key in keys])
            assert gap_of_links(step, sent) > 0
            arrived |= bool(np.abs(sent - there).max() < LEAD + 3.0)
    assert arrived


def gap_of_links(step: EndEffectorStep, degrees: NDArray[Any]) -> float:
    """How far the links are off each other beyond their margin, m."""
    q = np.radians(degrees)
    _, state = step._following.predict({"q": q, WANTED: q})
    model = step._following.model
    values, goals = model.values(state.memory), model.goals.values()
    return min(float(goal.gaps(values).min()) for goal in goals if not goal.has_room)
