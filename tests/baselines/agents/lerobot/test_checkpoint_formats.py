"""Policies are read in every format in which LeRobot has saved them, and in half precision."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

pytest.importorskip("lerobot")

from lerobot.policies.diffusion.modeling_diffusion import DiffusionPolicy
from safetensors.torch import load_file, save_file

from aicon_baselines.agents.diffusion.agent import Agent
from aicon_baselines.agents.diffusion.checkpoint import load
from aicon_baselines.agents.diffusion.export import export

STUDENT = Path("baselines", "checkpoints", "diffusion_pusht_keypoints")
MODES = {
    "observation.state": "mean_std",
    "observation.environment_state": "mean_std",
    "action": "min_max",
}

Observations = list[dict[str, np.ndarray]]
Act = Callable[..., np.ndarray]


def make_old(policy: Path, folder: Path, oldest: bool) -> Path:
    """Write a policy in a format with the normalisation inside the weights."""
    folder.mkdir()
    content = json.loads((policy / "config.json").read_text())
    if oldest:
        use_oldest_names(content)
    else:
        content["normalization_mapping"].pop("ENV")  # the defaults of that time had none
    (folder / "config.json").write_text(json.dumps(content))

    weights = load_file(policy / "model.safetensors")
    weights |= normalization_buffers(policy)
    save_file(weights, folder / "model.safetensors")
    return folder


def use_oldest_names(content: dict[str, Any]) -> None:
    for side in ("input", "output"):
        features = content.pop(f"{side}_features")
        content[f"{side}_shapes"] = {name: features[name]["shape"] for name in features}
        content[f"{side}_normalization_modes"] = {name: MODES[name] for name in features}
    for name in ("type", "normalization_mapping", "device", "use_amp"):
        del content[name]


def normalization_buffers(policy: Path) -> dict[str, torch.Tensor]:
    pattern = "policy_preprocessor_step_*_normalizer_processor.safetensors"
    statistics = load_file(next(policy.glob(pattern)))

    buffers = {}
    for name, mode in MODES.items():
        buffer = f"buffer_{name.replace('.', '_')}"
        layers = ["normalize_inputs"]
        if name == "action":
            layers = ["normalize_targets", "unnormalize_outputs"]
        for layer in layers:
            for statistic in mode.split("_"):
                value = statistics[f"{name}.{statistic}"].float().clone()
                buffers[f"{layer}.{buffer}.{statistic}"] = value
    return buffers


@pytest.mark.parametrize("oldest", [True, False])
def test_old_formats_act_like_todays(
    oldest: bool, policy: Path, tmp_path: Path, observations: Observations, act: Act
) -> None:
    old = make_old(policy, tmp_path / "old", oldest)
    expected = act(Agent(policy, "DDIM", 5), observations)
    assert np.allclose(act(Agent(old, "DDIM", 5), observations), expected, atol=1e-2)


def test_a_newer_version_is_read(policy: Path, tmp_path: Path) -> None:
    folder = shutil.copytree(policy, tmp_path / "policy")
    path = folder / "config.json"
    newer = {"gradient_checkpointing": False, "pretrained_revision": None}
    path.write_text(json.dumps(json.loads(path.read_text()) | newer))
    assert Agent(folder).name == Agent(policy).name


def test_half_precision_is_loaded_as_float32(
    policy: Path, tmp_path: Path, observations: Observations, act: Act
) -> None:
    folder = tmp_path / "half"
    export(policy.parent, folder, sampler="DDIM", inference_steps=5)
    assert (folder / "loss.png").stat().st_size < 100_000
    weights = load_file(folder / "model.safetensors")
    assert {value.dtype for value in weights.values()} == {torch.float16}

    ours, theirs = load(folder).policy, DiffusionPolicy.from_pretrained(folder)
    for our_weights, their_weights in zip(ours.parameters(), theirs.parameters(), strict=True):
        assert our_weights.dtype == their_weights.dtype == torch.float32
        assert torch.equal(our_weights, their_weights)
    assert theirs.diffusion.num_inference_steps == 5

    exported = act(Agent(folder), observations[:4])
    original = act(Agent(policy, "DDIM", 5), observations[:4])
    assert np.abs(exported - original).max() < 2.0  # px


def test_the_student_that_comes_along_is_small_and_loads(
    observations: Observations, act: Act, pytestconfig: pytest.Config
) -> None:
    folder = pytestconfig.rootpath / STUDENT
    assert sum(file.stat().st_size for file in folder.iterdir()) < 20e6

    agent, theirs = Agent(folder), DiffusionPolicy.from_pretrained(folder)
    ours = agent._checkpoint.policy
    for our_weights, their_weights in zip(ours.parameters(), theirs.parameters(), strict=True):
        assert torch.equal(our_weights, their_weights)

    actions = act(agent, observations)
    assert actions.shape == (12, 4, 2)
    assert (actions > 0.0).all() and (actions < 512.0).all()
