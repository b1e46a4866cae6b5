"""What is no policy, or cannot be found, is an error that says what to do."""

import json
import re
import shutil
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("lerobot")

from huggingface_hub import constants

from aicon_baselines.agents.diffusion import hub
from aicon_baselines.agents.diffusion.agent import Agent
from aicon_baselines.evaluation import ComparisonError

COMMIT = "0123456789" * 4


def edit(folder: Path, **values: Any) -> None:
    path = folder / "config.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | values))


def act_like_an_arm(folder: Path) -> None:
    edit(folder, output_features={"action": {"type": "ACTION", "shape": [7]}})


def remove_processors(folder: Path) -> None:
    for file in folder.glob("policy_*"):
        file.unlink()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            lambda folder: (folder / "config.json").unlink(),
            "is no saved policy, config.json is missing; train one: python scripts",
        ),
        (
            lambda folder: (folder / "config.json").write_text("x"),
            "config.json holds no JSON",
        ),
        (
            lambda folder: edit(folder, type="act"),
            "config.json describes a policy of type 'act', not 'diffusion'",
        ),
        (
            lambda folder: edit(folder, colour="red"),
            "options that the installed LeRobot does not know: colour; save the policy",
        ),
        (
            lambda folder: edit(folder, down_dims=[8, 16, 32, 64, 128]),
            "config.json is not a diffusion policy's",
        ),
        (
            lambda folder: edit(folder, down_dims=[16, 32]),
            "model.safetensors does not fit",
        ),
        (act_like_an_arm, "model.safetensors does not fit"),
        (
            lambda folder: (folder / "model.safetensors").unlink(),
            "has no model.safetensors; copy the whole folder",
        ),
        (
            lambda folder: (folder / "model.safetensors").write_text("x"),
            "model.safetensors holds no weights",
        ),
        (
            remove_processors,
            "has no policy_preprocessor.json and policy_postprocessor.json, and "
            "model.safetensors no",
        ),
    ],
)
def test_a_folder_that_is_no_policy_is_an_error(
    change: Any, message: str, policy: Path, tmp_path: Path
) -> None:
    folder = shutil.copytree(policy, tmp_path / "policy")
    change(folder)
    with pytest.raises(ComparisonError, match=re.escape(message)):
        Agent(folder)


def test_the_folder_of_a_training_points_to_its_policy(policy: Path) -> None:
    message = f"config.json is missing; take {policy}"
    with pytest.raises(ComparisonError, match=re.escape(message)):
        Agent(policy.parent)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"sampler": "EULER"}, "unknown sampler 'EULER'; valid samplers: DDPM, DDIM"),
        ({"inference_steps": 101}, "inference steps must be between 1 and 100, not 101"),
    ],
)
def test_samplers_that_do_not_exist_are_an_error(
    options: dict[str, Any], message: str, policy: Path
) -> None:
    with pytest.raises(ComparisonError, match=re.escape(message)):
        Agent(policy, **options)


@pytest.mark.parametrize("offline", [True, False])
def test_without_the_hub_an_error_says_what_to_download(
    offline: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(constants, "HF_HUB_CACHE", str(tmp_path))
    monkeypatch.setattr(constants, "HF_HUB_OFFLINE", offline)
    monkeypatch.setattr(constants, "ENDPOINT", "http://127.0.0.1:9")

    reason = "HF_HUB_OFFLINE is set" if offline else "does not answer"
    message = rf"{reason}.*Download config.json.*--diffusion-path runs/diffusion_pusht"
    with pytest.raises(ComparisonError, match=message):
        Agent(f"lerobot/diffusion_pusht@{COMMIT}")


def test_what_was_downloaded_before_is_found(
    policy: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(constants, "HF_HUB_CACHE", str(tmp_path))
    cached = tmp_path / "models--owner--name"
    shutil.copytree(policy, cached / "snapshots" / COMMIT)

    assert hub.locate(f"owner/name@{COMMIT}") == cached / "snapshots" / COMMIT
