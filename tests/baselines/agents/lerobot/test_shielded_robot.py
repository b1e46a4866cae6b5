"""A robot of LeRobot behind a shield: nothing is touched, and what is sent is what is said."""

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("lerobot")
pytest.importorskip("mujoco")
pytest.importorskip("lerobot_robot_aicon")

from _so101 import JOINTS, AboveTable, described, joints, to_action
from lerobot.datasets.lerobot_dataset import LeRobotDataset

from lerobot_robot_aicon import AiconShield, AiconShieldConfig, AiconSimulatedConfig

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
