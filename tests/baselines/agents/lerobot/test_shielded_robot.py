"""A robot of LeRobot behind a shield: nothing is touched, and what is sent is what is said."""

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

pytest.importorskip("lerobot")
pytest.importorskip("mujoco")
pytest.importorskip("lerobot_robot_aicon")

import torch
from lerobot.datasets.lerobot_dataset import LeRobotDataset

from aicon_envs.reach import ReachEnv
from aicon_torch.parts import CapsuleSegments, Robot, SquaredHinge, Table
from lerobot_robot_aicon import AiconShield, AiconShieldConfig, AiconSimulatedConfig

pytestmark = pytest.mark.slow

JOINTS = ("shoulder_pan", "shoulder_lift", "elbow_flex", "wrist_flex", "wrist_roll")


@pytest.fixture(scope="module")
def shielded() -> Iterator[AiconShield]:
    config = AiconShieldConfig(inner=AiconSimulatedConfig(seed=3), urdf="so101", table=0.0)
    robot = AiconShield(config)
    robot.connect()
    yield robot
    robot.disconnect()


def to_action(degrees: Any) -> dict[str, float]:
    return {f"{joint}.pos": float(x) for joint, x in zip(JOINTS, degrees, strict=True)}


def joints(observation: dict[str, Any]) -> NDArray[Any]:
    return np.radians([observation[f"{joint}.pos"] for joint in JOINTS])


def test_wherever_it_is_sent_it_touches_neither_itself_nor_the_table(shielded: AiconShield) -> None:
    described = ReachEnv("so101", "axis").description()
    arm = Robot.from_urdf(described["urdf"], tip=described["tip"])
    assert arm.shape is not None
    table = Table.under(arm, 0.0, SquaredHinge(0.01, 1.0))
    segments = CapsuleSegments(arm.chain, arm.shape.capsules)

    generator, sent_into_it = np.random.default_rng(1), 0
    for _ in range(15):
        posture = generator.uniform(described["low"], described["high"])
        sent_into_it += int(table.distances(segments(torch.tensor(posture))).min() < 0)
        for _ in range(40):
            observation = shielded.get_observation()
            shielded.send_action(to_action(np.degrees(posture)))
            assert table.distances(segments(torch.tensor(joints(observation)))).min() > 0
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
