"""Saved diffusion policies of LeRobot, in today's format and older ones."""

import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from torch import Tensor

from aicon_baselines.agents.diffusion.checkpoint_formats import (
    Statistics,
    build_config,
    read_shapes,
    split_statistics,
)
from aicon_baselines.agents.diffusion.lerobot_names import import_lerobot
from aicon_baselines.evaluation.errors import ComparisonError, check_known
from aicon_baselines.files import read_json

CONFIG = "config.json"
WEIGHTS = "model.safetensors"
PREPROCESSOR = "policy_preprocessor.json"
POSTPROCESSOR = "policy_postprocessor.json"

SAMPLERS = ("DDPM", "DDIM")

_TRAIN_ONE = "train one: python scripts/train_diffusion.py --data DEMONSTRATIONS --out FOLDER"


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


def load(
    folder: Path, sampler: str | None = None, inference_steps: int | None = None
) -> Checkpoint:
    """Load a policy of either format, on the CPU; weights in half precision become float32.

    Args:
        folder: Folder with `config.json` and `model.safetensors`.
        sampler: "DDPM" or "DDIM"; by default the checkpoint's.
        inference_steps: Number of denoising steps; by default the checkpoint's, which is all it was
            trained with.

    Raises:
        ComparisonError: Where something is missing; it names the file.
    """
    import_lerobot("policies.factory")  # without LeRobot, nothing else needs to be looked at

    # 1. Read the files.
    content = _read_config(folder)
    features = read_shapes(content, "input") | read_shapes(content, "output")
    weights, statistics = split_statistics(read_weights(folder), features)

    # 2. Describe the policy.
    config = build_config(folder / CONFIG, content, statistics)
    _set_sampler(config, sampler, inference_steps)

    # 3. Build it.
    policy = _build_policy(folder, config, weights)
    preprocess, postprocess = _build_processors(folder, config, statistics)
    return Checkpoint(policy.eval(), preprocess, postprocess)


def save(policy: Any, preprocess: Any, postprocess: Any, folder: Path) -> None:
    """Write a policy and its processors as LeRobot does, whole or, after a kill, not at all."""
    temporary = folder.with_name(folder.name + ".tmp")
    shutil.rmtree(temporary, ignore_errors=True)

    policy.save_pretrained(temporary)
    preprocess.save_pretrained(temporary)
    postprocess.save_pretrained(temporary)

    shutil.rmtree(folder, ignore_errors=True)
    temporary.replace(folder)


def read_weights(folder: Path) -> dict[str, Tensor]:
    """Read `model.safetensors`; an error if it is missing or holds no weights."""
    from safetensors import SafetensorError
    from safetensors.torch import load_file

    path = folder / WEIGHTS
    if not path.exists():
        raise ComparisonError(
            f"{folder} has no {WEIGHTS}; copy the whole folder from where the policy was saved"
        )

    try:
        return dict(load_file(path))
    except SafetensorError as error:
        raise ComparisonError(f"{path} holds no weights ({error}); copy it again") from error


def check_steps(path: Path) -> None:
    """Check that a processor is made of LeRobot's own steps.

    LeRobot also takes a step as the path of any class, which it imports and calls: whoever wrote
    such a file could run what they like.

    Raises:
        ComparisonError: If the file names such a class, or lists no steps.
    """
    steps = read_json(path).get("steps")
    if not isinstance(steps, list):
        raise ComparisonError(f"{path} lists no steps; copy it from where the policy was saved")

    for step in steps:
        if not isinstance(step, dict) or "registry_name" not in step:
            raise ComparisonError(
                f"{path} has a step that is none of LeRobot's, but code to run: {step}. "
                "A step is expected to have a registry_name"
            )


def _read_config(folder: Path) -> dict[str, Any]:
    """Read `config.json`, which has to be that of a diffusion policy."""
    path = folder / CONFIG
    if not path.exists():
        policies_inside = sorted(folder.glob(f"*/{CONFIG}"))
        hint = f"take {policies_inside[0].parent}" if policies_inside else _TRAIN_ONE
        raise ComparisonError(f"{folder} is no saved policy, {CONFIG} is missing; {hint}")

    try:
        content = read_json(path)
    except ComparisonError as error:
        raise ComparisonError(f"{error}; {_TRAIN_ONE}") from error

    # The oldest format does not name the type.
    policy_type = content.get("type", "diffusion" if "down_dims" in content else None)
    if policy_type != "diffusion":
        raise ComparisonError(
            f"{path} describes a policy of type {policy_type!r}, not 'diffusion'; {_TRAIN_ONE}"
        )
    return content


def _set_sampler(config: Any, sampler: str | None, inference_steps: int | None) -> None:
    """Set how actions are sampled, where it is not None; an error if it cannot be."""
    if sampler is not None:
        check_known("sampler", sampler, SAMPLERS)
        config.noise_scheduler_type = sampler

    if inference_steps is not None:
        if not 1 <= inference_steps <= config.num_train_timesteps:
            raise ComparisonError(
                f"inference steps must be between 1 and {config.num_train_timesteps}, "
                f"not {inference_steps}"
            )
        config.num_inference_steps = inference_steps


def _build_policy(folder: Path, config: Any, weights: dict[str, Tensor]) -> Any:
    policy = import_lerobot("policies.diffusion.modeling_diffusion").DiffusionPolicy(config)

    try:
        policy.load_state_dict({name: value.float() for name, value in weights.items()})
    except RuntimeError as error:
        raise ComparisonError(
            f"{folder / WEIGHTS} does not fit {folder / CONFIG} ({error}); "
            "copy both from the same policy"
        ) from error
    return policy


def _build_processors(folder: Path, config: Any, statistics: Statistics) -> tuple[Any, Any]:
    """Return what stands before and after the network, from their files or old statistics."""
    make_processors = import_lerobot("policies.factory").make_pre_post_processors

    if (folder / PREPROCESSOR).exists() and (folder / POSTPROCESSOR).exists():
        check_steps(folder / PREPROCESSOR)
        check_steps(folder / POSTPROCESSOR)
        on_cpu = {"device_processor": {"device": "cpu"}}
        preprocess, postprocess = make_processors(
            config, pretrained_path=str(folder), preprocessor_overrides=on_cpu
        )
    elif statistics:
        preprocess, postprocess = make_processors(config, dataset_stats=statistics)
    else:
        raise ComparisonError(
            f"{folder} has no {PREPROCESSOR} and {POSTPROCESSOR}, and {WEIGHTS} no normalisation: "
            "copy the whole folder from where the policy was saved"
        )

    return preprocess, postprocess
