"""A robot of LeRobot behind a shield: nothing is touched, and what is sent is what is said."""

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("lerobot")
pytest.importorskip("mujoco")
pytest.importorskip("lerobot_robot_aicon")

from _so101 import JOINTS, AboveTable, described, joints, to_action
from lerobot.cameras.opencv.configuration_opencv import OpenCVCameraConfig
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from lerobot.utils.errors import DeviceNotConnectedError

from lerobot_robot_aicon import (
    AiconShield,
    AiconShieldConfig,
    AiconSimulated,
    AiconSimulatedConfig,
)
from lerobot_robot_aicon.arm_options import ShieldOptions, described_arm
from lerobot_robot_aicon.joint_shield import JointShield
from lerobot_robot_aicon.motors import Motors

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def shielded() -> Iterator[AiconShield]:
    config = AiconShieldConfig(inner=AiconSimulatedConfig(seed=3), urdf="so101", table=0.0)
    robot = AiconShield(config)
    robot.connect()
    yield robot
    robot.disconnect()


def test_wherever_it_is_sent_it_touches_neither_itself_nor_the_table(shielded: AiconShield) -> None:
    above_table = AboveTable()
    low, high = described()["low"], described()["high"]
    generator, sent_into_it = np.random.default_rng(1), 0
    for _ in range(15):
        posture = generator.uniform(low, high)
        sent_into_it += int(above_table(posture) < 0)
        for _ in range(40):
            observation = shielded.get_observation()
            shielded.send_action(to_action(np.degrees(posture)))
            assert above_table(joints(observation)) > 0
            assert not shielded.inner.info["self_contact"]
            assert not shielded.inner.info["limit_violation"]
    assert sent_into_it > 1


def test_where_nothing_is_near_it_arrives_and_says_what_was_sent(shielded: AiconShield) -> None:
    wanted = to_action([20.0, -60.0, 50.0, 30.0, 0.0])
    for _ in range(150):
        shielded.get_observation()
        sent = shielded.send_action(wanted)
    assert sent == pytest.approx(wanted, abs=0.1)
    assert joints(shielded.get_observation()) == pytest.approx(joints(wanted), abs=0.02)
    assert "done" in str(shielded.explain())


def test_who_never_looks_is_judged_by_where_the_robot_is(shielded: AiconShield) -> None:
    wanted = to_action([-60.0, -60.0, 50.0, 30.0, 0.0])
    for _ in range(300):
        shielded.send_action(wanted)
    assert joints(shielded.get_observation()) == pytest.approx(joints(wanted), abs=0.02)


def test_what_is_not_finite_stays_where_it_is(shielded: AiconShield) -> None:
    for _ in range(90):
        shielded.get_observation()
        shielded.send_action(to_action([20.0, -60.0, 50.0, 30.0, 0.0]))
    before = joints(shielded.get_observation())
    for _ in range(30):
        shielded.get_observation()
        shielded.send_action({"shoulder_pan.pos": np.nan, "gripper.pos": np.nan})
    assert joints(shielded.get_observation()) == pytest.approx(before, abs=0.01)


def test_an_arm_that_is_held_goes_on_once_it_is_let_go() -> None:
    shield = JointShield(ShieldOptions(urdf="so101"))
    measured = to_action([0.0, -30.0, 30.0, 30.0, 0.0])
    wanted = to_action([40.0, -60.0, 60.0, 60.0, 30.0])
    assert shield(measured, wanted) == {}
    for step in range(150):
        sent = shield(measured, wanted)
        if step >= 60:
            measured = sent
    assert sent == pytest.approx(wanted, abs=0.5)


def test_an_action_of_no_motor_is_refused(shielded: AiconShield) -> None:
    with pytest.raises(ValueError, match=r"no elbow\.pos; it has shoulder_pan\.pos"):
        shielded.send_action({"elbow.pos": 0.0})


def test_it_says_in_the_log_what_it_changed(
    shielded: AiconShield, caplog: pytest.LogCaptureFixture
) -> None:
    shielded.connect()
    with caplog.at_level("INFO"):
        for _ in range(40):
            shielded.get_observation()
            shielded.send_action(to_action([0.0, 90.0, -30.0, 90.0, 0.0]))
        shielded.disconnect()
    shielded.connect()
    assert "table: a gap of" in caplog.text
    assert " of 40 actions were changed" in caplog.text


def test_an_arm_that_stands_otherwise_than_described_is_not_moved() -> None:
    config = AiconShieldConfig(
        inner=AiconSimulatedConfig(seed=3), urdf="so101", table=0.0, offsets={"elbow_flex": 200.0}
    )
    robot = AiconShield(config)
    robot.connect()
    before = robot.get_observation()
    with pytest.raises(ValueError, match=r"elbow_flex seems to stand at .* --robot\.offsets"):
        robot.send_action({"shoulder_pan.pos": 0.0})
    assert robot.get_observation() == before


def test_an_arm_that_is_not_calibrated_is_not_moved(
    shielded: AiconShield, monkeypatch: pytest.MonkeyPatch
) -> None:
    shielded.connect(calibrate=False)
    before = shielded.get_observation()
    monkeypatch.setattr(AiconSimulated, "is_calibrated", False)
    monkeypatch.setattr(AiconSimulated, "send_action", lambda *_: pytest.fail("it was moved"))
    for _ in range(3):
        with pytest.raises(ValueError, match=r"AiconSimulated is not calibrated.*calibrate=True"):
            shielded.send_action(before)

    # Once it is calibrated it moves, and so does one that knows of no calibration.
    monkeypatch.undo()
    for known in (True, None):
        shielded.connect(calibrate=False)
        monkeypatch.setattr(AiconSimulated, "is_calibrated", known)
        assert [bool(shielded.send_action(before)) for _ in range(2)] == [False, True]


@pytest.mark.parametrize("option", ["motors", "offsets", "signs"])
def test_a_joint_that_the_description_does_not_have_is_named(option: str) -> None:
    wrong: dict[str, Any] = {option: {"elbow": 1}}
    config = AiconShieldConfig(inner=AiconSimulatedConfig(), urdf="so101", **wrong)
    with pytest.raises(ValueError, match=f"{option}: the description has no joint elbow; it has"):
        AiconShield(config)


def test_a_tip_of_an_arm_that_has_one_is_refused() -> None:
    config = AiconShieldConfig(inner=AiconSimulatedConfig(), urdf="so101", tip="elsewhere")
    with pytest.raises(ValueError, match="tip='elsewhere': so101 has 'gripper_frame_link'"):
        AiconShield(config)
    with pytest.raises(ValueError, match="srdf='elsewhere': so101 has None; leave it out"):
        described_arm(ShieldOptions(urdf="so101", srdf="elsewhere"))


def test_a_motor_that_would_turn_two_joints_is_refused() -> None:
    options = ShieldOptions(urdf="so101", motors={"elbow_flex": "wrist_flex"})
    with pytest.raises(ValueError, match="a motor turns two joints.*wrist_flex.pos, wrist_flex"):
        Motors(JOINTS, options)


def test_a_motor_that_counts_the_other_way_round_turns_the_other_way() -> None:
    options = ShieldOptions(urdf="so101", signs={"wrist_roll": -1}, offsets={"wrist_roll": 10.0})
    motors = Motors(JOINTS, options)
    q = motors.read(to_action([0.0, 0.0, 0.0, 0.0, 30.0]))
    assert np.degrees(q) == pytest.approx([0.0, 0.0, 0.0, 0.0, -20.0])
    assert motors.written(q)["wrist_roll.pos"] == pytest.approx(30.0)


def test_the_simulated_arm_has_a_gripper_and_pictures() -> None:
    camera = OpenCVCameraConfig(index_or_path=0, width=64, height=48, fps=30)
    robot = AiconSimulated(AiconSimulatedConfig(cameras={"front": camera}))
    with pytest.raises(DeviceNotConnectedError):
        robot.get_observation()
    robot.connect()
    robot.send_action({**to_action([0.0] * 5), "gripper.pos": 40.0})
    observation = robot.get_observation()
    assert observation.keys() == robot.observation_features.keys()
    assert observation["gripper.pos"] == 40.0
    assert observation["front"].shape == robot.observation_features["front"] == (48, 64, 3)
    assert observation["front"].std() > 1.0


def test_how_an_arm_stands_is_printed_and_every_robot_of_lerobot_is_known() -> None:
    module = (sys.executable, "-m", "lerobot_robot_aicon.standing", "--robot.urdf=so101")
    options = ("--robot.inner.type=aicon_simulated", "--duration=0.5")
    done = subprocess.run((*module, *options), capture_output=True, text=True)
    assert "the tip is" in done.stdout, done.stderr[-2000:]

    told = subprocess.run((*module, "--robot.inner.type=none"), capture_output=True, text=True)
    assert "so101_follower" in told.stderr


def test_a_motor_that_is_missing_is_named() -> None:
    config = AiconShieldConfig(
        inner=AiconSimulatedConfig(), urdf="so101", motors={"elbow_flex": "elbow"}
    )
    with pytest.raises(ValueError, match=r"no elbow\.pos: it has shoulder_pan.*--robot\.motors"):
        AiconShield(config)


def test_it_is_a_robot_of_the_command_line(tmp_path: Path) -> None:
    names = [f"{joint}.pos" for joint in JOINTS]
    features = {"action": {"dtype": "float32", "shape": (5,), "names": names}}
    folder = tmp_path / "data"
    dataset = LeRobotDataset.create("test/joints", 30, features, folder, use_videos=False)
    for number in range(20):
        target = np.full(5, 90.0 * number / 20, np.float32)
        dataset.add_frame({"action": target, "task": "move"})
    dataset.save_episode()
    dataset.finalize()

    command = [
        *(sys.executable, "-m", "lerobot.scripts.lerobot_replay", "--robot.type=aicon_shield"),
        *("--robot.inner.type=aicon_simulated", "--robot.urdf=so101", "--robot.table=0.0"),
        *("--dataset.repo_id=test/joints", f"--dataset.root={folder}"),
        *("--dataset.episode=0", "--play_sounds=false"),
    ]
    done = subprocess.run(
        command, capture_output=True, text=True, env={**os.environ, "HF_HUB_OFFLINE": "1"}
    )
    assert done.returncode == 0, done.stderr[-2000:]
