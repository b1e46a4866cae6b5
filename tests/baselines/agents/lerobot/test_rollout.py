"""A policy that drives an arm into the table, run by LeRobot's own command behind a shield."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import torch

pytest.importorskip("lerobot.rollout", reason="LeRobot has no lerobot-rollout before 0.6")
pytest.importorskip("mujoco")
pytest.importorskip("lerobot_robot_aicon")

from _so101 import AboveTable, described
from lerobot.configs.types import FeatureType, PolicyFeature
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from lerobot.policies.factory import get_policy_class, make_pre_post_processors
from lerobot.policies.gaussian_actor.configuration_gaussian_actor import GaussianActorConfig
from numpy.typing import NDArray

pytestmark = pytest.mark.slow


def write_policy(folder: Path, target: NDArray[np.float32]) -> None:
    """An untrained network whose actions, degrees, lie within one degree of a target ``(5,)``."""
    config = GaussianActorConfig(
        input_features={"observation.state": PolicyFeature(FeatureType.STATE, (5,))},
        output_features={"action": PolicyFeature(FeatureType.ACTION, (5,))},
        device="cpu",
        push_to_hub=False,
    )
    get_policy_class("gaussian_actor")(config).save_pretrained(folder)

    around = torch.from_numpy(target)
    statistics = {
        "observation.state": {"min": torch.full((5,), -180.0), "max": torch.full((5,), 180.0)},
        "action": {"min": around - 1, "max": around + 1},
    }
    for processor in make_pre_post_processors(config, dataset_stats=statistics):
        processor.save_pretrained(folder)


def posture_in_the_table() -> NDArray[np.float32]:
    """The joints ``(5,)``, degrees, of a posture whose links are below the table."""
    above_table, generator = AboveTable(), np.random.default_rng(2)
    postures = generator.uniform(described()["low"], described()["high"], (200, 5))
    below = np.flatnonzero(above_table(postures).numpy() < -0.05)
    return np.degrees(postures[below[0]]).astype(np.float32)


def test_it_asks_for_what_is_in_the_table_and_does_not_get_it(tmp_path: Path) -> None:
    write_policy(tmp_path / "policy", posture_in_the_table())
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

    frames = LeRobotDataset("test/rollout_so101", root=tmp_path / "data").hf_dataset
    above_table = AboveTable()
    asked = np.radians(np.stack(frames["action"]))
    reached = np.radians(np.stack(frames["observation.state"]))
    assert above_table(asked).max() < 0
    assert above_table(reached).min() > 0
    assert np.abs(reached[-1] - reached[0]).max() > 0.2
