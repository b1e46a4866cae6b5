import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

pytest.importorskip("lerobot")

from lerobot.policies.diffusion.modeling_diffusion import DiffusionPolicy
from lerobot.policies.factory import make_pre_post_processors

from aicon_baselines.agents.diffusion import learner, training
from aicon_baselines.agents.diffusion.checkpoint import load, save
from aicon_baselines.agents.diffusion.configs import TrainingConfig
from aicon_baselines.agents.diffusion.dataset import Frames, read_frames
from aicon_baselines.agents.diffusion.learner import make_policy_config
from aicon_baselines.agents.diffusion.training import train
from aicon_baselines.evaluation import ComparisonError


def test_a_stopped_training_ends_like_one_that_was_not(
    demos: Path, small: dict[str, Any], tmp_path: Path
) -> None:
    config = TrainingConfig(8, **small)
    train(config, demos, tmp_path / "whole")

    lines: list[str] = []
    assert train(config, demos, tmp_path / "parts", stop_after=0.0) == 1
    assert train(config, demos, tmp_path / "parts", checkpoint=4, report=lines.append) == 8

    assert len(lines) == 2 and "nan" not in "".join(lines)
    for name in ("policy/model.safetensors", "policy/config.json"):
        whole, parts = tmp_path / "whole" / name, tmp_path / "parts" / name
        assert whole.read_bytes() == parts.read_bytes()


@pytest.mark.parametrize("killed_at", [pytest.param("save", marks=pytest.mark.slow), "torch.save"])
def test_a_training_that_is_killed_at_its_last_save_gets_its_policy(
    killed_at: str,
    demos: Path,
    small: dict[str, Any],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    config = TrainingConfig(4, **small)
    train(config, demos, tmp_path / "whole")

    def kill(*_: Any) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patch, pytest.raises(KeyboardInterrupt):
        patch.setattr(f"{learner.__name__}.{killed_at}", kill)
        train(config, demos, tmp_path / "killed")

    train(config, demos, tmp_path / "killed")
    name = "policy/model.safetensors"
    assert (tmp_path / "whole" / name).read_bytes() == (tmp_path / "killed" / name).read_bytes()


def test_another_training_is_not_overwritten(
    demos: Path, small: dict[str, Any], policy: Path
) -> None:
    other = TrainingConfig(8, **small | {"batch": 16})
    message = "another training: batch is 8 there and 16 here. Choose another folder"
    with pytest.raises(ComparisonError, match=message):
        train(other, demos, policy.parent)


def test_a_loss_that_is_no_number_leaves_what_was_saved(
    demos: Path, small: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    train(TrainingConfig(2, **small), demos, tmp_path)
    saved = (tmp_path / "policy/model.safetensors").read_bytes()

    def read_without_actions(folder: Path, observation: str) -> Frames:
        frames = read_frames(folder, observation)
        frames.columns["action"][:] = np.nan
        return frames

    monkeypatch.setattr(training, "read_frames", read_without_actions)
    with pytest.raises(ComparisonError, match=r"the loss of step 3 is nan: take a smaller"):
        train(TrainingConfig(4, **small), demos, tmp_path, checkpoint=1)
    assert (tmp_path / "policy/model.safetensors").read_bytes() == saved


@pytest.fixture(scope="module")
def begun(demos: Path, small: dict[str, Any], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a training of one step."""
    folder = tmp_path_factory.mktemp("begun")
    train(TrainingConfig(1, **small), demos, folder)
    return folder


@pytest.mark.parametrize("content", [b"", b"nothing", {"step": 1}, {"policy": {}}, [1]])
def test_what_no_training_goes_on_from_is_a_sentence(
    content: Any, begun: Path, demos: Path, small: dict[str, Any], tmp_path: Path
) -> None:
    shutil.copytree(begun, tmp_path, dirs_exist_ok=True)
    file = tmp_path / "training.pt"
    file.write_bytes(content) if isinstance(content, bytes) else torch.save(content, file)
    with pytest.raises(
        ComparisonError, match=r"training\.pt is not what this training goes on from"
    ):
        train(TrainingConfig(2, **small), demos, tmp_path)


def test_a_training_goes_on_with_more_steps(
    demos: Path, small: dict[str, Any], tmp_path: Path
) -> None:
    train(TrainingConfig(4, **small), demos, tmp_path)
    assert train(TrainingConfig(6, **small), demos, tmp_path) == 6
    assert json.loads((tmp_path / "training.json").read_text())["steps"] == 6


def test_observations_are_shifted_by_standard_deviations(demos: Path, policy: Path) -> None:
    frames = read_frames(demos, "keypoints")
    names = ("observation.state", "observation.environment_state")
    columns = {name: torch.from_numpy(frames.columns[name]) for name in names}

    seen = load(policy).preprocess(columns)

    for name in names:
        assert torch.allclose(seen[name].mean(dim=0), torch.tensor(2.0), atol=1e-2)
        assert torch.allclose(seen[name].std(dim=0), torch.tensor(1.0), atol=1e-2)


@pytest.mark.slow
def test_training_lowers_the_loss(demos: Path, small: dict[str, Any], tmp_path: Path) -> None:
    config = TrainingConfig(200, **small | {"batch": 32}, learning_rate=3e-3)
    train(config, demos, tmp_path)

    text = (tmp_path / "loss.csv").read_text()
    header, first, second = [line.split(",") for line in text.splitlines()]
    assert header == ["step", "loss", "learning_rate", "seconds"]
    assert (first[0], second[0]) == ("100", "200")
    assert float(second[1]) < 0.95 * float(first[1])


@pytest.mark.slow
def test_pixel_policies_keep_their_options(
    demos: Path, small: dict[str, Any], tmp_path: Path
) -> None:
    frames = read_frames(demos, "pixels")
    learned = TrainingConfig(1, observation="pixels", **small)
    config = make_policy_config(learned, frames.features)
    assert config.crop_shape == (84, 84) and config.use_group_norm

    processors = make_pre_post_processors(config, dataset_stats=frames.statistics)
    save(DiffusionPolicy(config), *processors, tmp_path / "policy")

    loaded = load(tmp_path / "policy").policy.config
    assert loaded.crop_shape == (84, 84)
    assert loaded.down_dims == (8, 16)
    assert loaded.use_group_norm
