"""A policy that drives an arm into the table, run by LeRobot's own command behind a shield."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("lerobot.rollout", reason="LeRobot has no lerobot-rollout before 0.6")
pytest.importorskip("mujoco")
pytest.importorskip("lerobot_robot_aicon")

from _so101 import AboveTable
from lerobot.datasets.lerobot_dataset import LeRobotDataset

from lerobot_robot_aicon.demo_policy import write_policy

pytestmark = pytest.mark.slow


def test_it_asks_for_what_is_in_the_table_and_does_not_get_it(tmp_path: Path) -> None:
    write_policy(tmp_path / "policy")
    command = [
        *(sys.executable, "-m", "lerobot.scripts.lerobot_rollout", "--strategy.type=episodic"),
        *("--robot.type=aicon_shield", "--robot.inner.type=aicon_simulated"),
        *("--robot.urdf=so101", "--robot.table=0.0", "--device=cpu", "--play_sounds=false"),
        *(f"--policy.path={tmp_path / 'policy'}", "--task=move"),
        *("--dataset.repo_id=test/rollout_so101", f"--dataset.root={tmp_path / 'data'}"),
        *("--dataset.single_task=move", "--dataset.push_to_hub=false"),
        *("--dataset.num_episodes=1", "--dataset.episode_time_s=5", "--dataset.reset_time_s=0"),
    ]
    offline = {**os.environ, "HF_HUB_OFFLINE": "1"}
    done = subprocess.run(command, capture_output=True, text=True, env=offline)
    assert done.returncode == 0, done.stderr[-2000:]
    assert "actions were changed" in done.stdout + done.stderr

    frames = LeRobotDataset("test/rollout_so101", root=tmp_path / "data").hf_dataset
    above_table = AboveTable()
    asked = np.radians(np.stack(frames["action"])[:, :5])
    reached = np.radians(np.stack(frames["observation.state"])[:, :5])
    assert above_table(asked).max() < 0
    assert above_table(reached).min() > 0
    assert np.abs(reached[-1] - reached[0]).max() > 0.2
