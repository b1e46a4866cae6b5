"""Saved diffusion policies of LeRobot, in today's format and the old one, with the normalisation inside the weights."""

import json
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

from torch import Tensor

from aicon_baselines.agents.diffusion.conversion import configure, shapes, split
from aicon_baselines.agents.diffusion.features import ACTION, KEYPOINTS, PIXELS, STATE
from aicon_baselines.agents.diffusion.installed import import_lerobot
from aicon_baselines.evaluation.errors import ComparisonError

CONFIG, WEIGHTS, PREPROCESSOR, POSTPROCESSOR = (
    "config.json",
    "model.safetensors",
    "policy_preprocessor.json",
    "policy_postprocessor.json",
)
_TRAINING = "train one: python scripts/train_diffusion.py --data DEMONSTRATIONS --out FOLDER"


@dataclass(frozen=True)
class Checkpoint:
    """A policy that has been loaded.

    Attributes:
        policy: LeRobot's `DiffusionPolicy`, in float32.
        preprocess: From observations as LeRobot reads them to what the network takes.
        postprocess: From what the network gives to actions, px.
    """

    policy: Any
    preprocess: Any
    postprocess: Any


def load(folder: Path, sampler: str | None = None, inference_steps: int | None = None) -> Checkpoint:
    """Load a policy of either format, on the CPU; weights in half precision become float32.

    Args:
        folder: Folder with `config.json` and `model.safetensors`.
        sampler: "DDPM" or "DDIM"; by default the checkpoint's.
        inference_steps: Number of denoising steps; by default the checkpoint's, which is all it was trained with.

    Returns:
        The policy; what is missing or does not fit pushT is an error that names the file.
    """
    factory = import_lerobot("policies.factory")
    content = _read_config(folder)
    weights, statistics = split(read_weights(folder), shapes(content, "input") | shapes(content, "output"))
    config = configure(folder / CONFIG, content, statistics)
    _check_features(folder, config)
    _override(config, sampler, inference_steps)
    policy: Any = import_lerobot("policies.diffusion.modeling_diffusion").DiffusionPolicy(config)
    try:
        policy.load_state_dict({name: value.float() for name, value in weights.items()})
    except RuntimeError as error:
        raise ComparisonError(
            f"{folder / WEIGHTS} does not fit {folder / CONFIG} ({error}); copy both from the same policy"
        ) from error
    if (folder / PREPROCESSOR).exists() and (folder / POSTPROCESSOR).exists():
        processors = factory.make_pre_post_processors(
            config, pretrained_path=str(folder), preprocessor_overrides={"device_processor": {"device": "cpu"}}
        )
    elif statistics:
        processors = factory.make_pre_post_processors(config, dataset_stats=statistics)
    else:
        raise ComparisonError(
            f"{folder} has no {PREPROCESSOR} and {POSTPROCESSOR}, and {WEIGHTS} no normalisation: copy the whole "
            "folder from where the policy was saved"
        )
    return Checkpoint(policy.eval(), *processors)


def save(policy: Any, preprocess: Any, postprocess: Any, folder: Path) -> None:
    """Write a policy and its processors as LeRobot does, all or nothing."""
    temporary = folder.with_name(folder.name + ".tmp")
    shutil.rmtree(temporary, ignore_errors=True)
    for part in (policy, preprocess, postprocess):
        part.save_pretrained(temporary)
    shutil.rmtree(folder, ignore_errors=True)
    temporary.replace(folder)


def _read_config(folder: Path) -> dict[str, Any]:
    path = folder / CONFIG
    if not path.exists():
        inside = [child.parent for child in sorted(folder.glob(f"*/{CONFIG}"))]
        hint = f"take {inside[0]}" if inside else _TRAINING
        raise ComparisonError(f"{folder} is no saved policy, {CONFIG} is missing; {hint}")
    try:
        content = json.loads(path.read_text())
    except ValueError as error:
        raise ComparisonError(f"{path} is not JSON ({error}); {_TRAINING}") from error
    kind = content.get("type", "diffusion" if "down_dims" in content else None)
    if kind != "diffusion":
        raise ComparisonError(f"{path} describes a policy of type {kind!r}, not 'diffusion'; {_TRAINING}")
    return cast("dict[str, Any]", content)


def read_weights(folder: Path) -> dict[str, Tensor]:
    """Read `model.safetensors`; an error if it is missing or holds no weights."""
    from safetensors import SafetensorError
    from safetensors.torch import load_file

    path = folder / WEIGHTS
    if not path.exists():
        raise ComparisonError(f"{folder} has no {WEIGHTS}; copy the whole folder from where the policy was saved")
    try:
        return dict(load_file(path))
    except SafetensorError as error:
        raise ComparisonError(f"{path} holds no weights ({error}); copy it again") from error


def _check_features(folder: Path, config: Any) -> None:
    """Reject a policy that sees or does something else than pushT offers."""
    inputs = {name: feature.shape for name, feature in config.input_features.items()}
    outputs = {name: feature.shape for name, feature in config.output_features.items()}
    fits = inputs.get(STATE) == (2,) and outputs == {ACTION: (2,)} and set(inputs) <= {STATE, KEYPOINTS, PIXELS}
    fits = fits and len(inputs) > 1 and inputs.get(KEYPOINTS, (16,)) == (16,)
    if not fits:
        raise ComparisonError(
            f"{folder / CONFIG} takes {inputs} and gives {outputs}; pushT offers {STATE} (2,), {KEYPOINTS} (16,) and "
            f"{PIXELS} (3, height, width), and takes {ACTION} (2,); {_TRAINING}"
        )


def _override(config: Any, sampler: str | None, inference_steps: int | None) -> None:
    """Set how actions are sampled, where it is not None; an error if it cannot be."""
    if sampler not in (None, "DDPM", "DDIM"):
        raise ComparisonError(f"unknown sampler {sampler!r}; valid samplers: DDPM, DDIM")
    if inference_steps is not None and not 1 <= inference_steps <= config.num_train_timesteps:
        raise ComparisonError(
            f"inference steps must be between 1 and {config.num_train_timesteps}, not {inference_steps}"
        )
    if sampler is not None:
        config.noise_scheduler_type = sampler
    if inference_steps is not None:
        config.num_inference_steps = inference_steps
