"""The formats in which LeRobot has saved diffusion policies, read as today's.

| | features in `config.json` | normalisation |
|---|---|---|
| until 2024 | `input_shapes`, `output_shapes` | statistics among the weights, modes in `input_normalization_modes` |
| until 2025 | `input_features`, `output_features` | statistics among the weights, modes in `normalization_mapping` |
| since | the same | files of their own, `policy_preprocessor.json` and `policy_postprocessor.json` |
"""

from dataclasses import fields
from pathlib import Path
from typing import Any

from torch import Tensor

from aicon_baselines.agents.diffusion.features import TYPES
from aicon_baselines.agents.diffusion.installed import import_lerobot
from aicon_baselines.evaluation.errors import ComparisonError

# Of versions other than the installed one, and without a meaning here.
_IGNORED = {"type", "gradient_checkpointing", "pretrained_revision", "use_peft", "device"}
_BUFFERS = ("normalize_inputs.", "normalize_targets.", "unnormalize_outputs.")

Statistics = dict[str, dict[str, Tensor]]
"""For each feature its `min` and `max`, or `mean` and `std`."""


def shapes(content: dict[str, Any], side: str) -> dict[str, tuple[int, ...]]:
    """Return the shapes of the inputs or outputs, in either format of the configuration."""
    if f"{side}_shapes" in content:
        return {name: tuple(shape) for name, shape in content[f"{side}_shapes"].items()}
    return {name: tuple(feature["shape"]) for name, feature in (content.get(f"{side}_features") or {}).items()}


def split(weights: dict[str, Tensor], features: dict[str, tuple[int, ...]]) -> tuple[dict[str, Tensor], Statistics]:
    """Separate the network's weights from the statistics that the old format keeps among them."""
    statistics: Statistics = {}
    for name in features:
        for start in _BUFFERS:
            buffer = f"{start}buffer_{name.replace('.', '_')}."
            found = {
                key.removeprefix(buffer): value.float() for key, value in weights.items() if key.startswith(buffer)
            }
            if found:
                statistics[name] = found
    return {name: value for name, value in weights.items() if not name.startswith(_BUFFERS)}, statistics


def configure(file: Path, content: dict[str, Any], statistics: Statistics) -> Any:
    """Build LeRobot's configuration from the content of a file of any version.

    Args:
        file: The file, for errors.
        content: What it holds.
        statistics: What `split` found: it tells what was normalised, and how, where the file does not.

    Returns:
        LeRobot's `DiffusionConfig`; an option that it does not know is an error.
    """
    types = import_lerobot("configs.types")
    kind: Any = import_lerobot("policies.diffusion.configuration_diffusion").DiffusionConfig

    def describe(side: str) -> dict[str, Any]:
        return {
            name: types.PolicyFeature(type=types.FeatureType[TYPES.get(name, "STATE")], shape=shape)
            for name, shape in shapes(content, side).items()
        }

    replaced = {
        f"{side}_{what}" for side in ("input", "output") for what in ("shapes", "features", "normalization_modes")
    }
    options = {name: value for name, value in content.items() if name not in replaced | _IGNORED}
    known = {field.name for field in fields(kind)}
    unknown = sorted(options.keys() - known)
    if unknown:
        raise ComparisonError(
            f"{file} has options that the installed LeRobot does not know: {', '.join(unknown)}; save the "
            "policy with the version that make lerobot-env installs"
        )
    modes = dict(content.get("normalization_mapping") or {})
    # What the old format normalised is what it has statistics of.
    modes |= {TYPES[name]: "MEAN_STD" if "mean" in found else "MIN_MAX" for name, found in statistics.items()}
    options = {name: tuple(value) if isinstance(value, list) else value for name, value in options.items()}
    options |= {
        "input_features": describe("input"),
        "output_features": describe("output"),
        "normalization_mapping": {name: types.NormalizationMode[mode] for name, mode in modes.items()},
        "pretrained_backbone_weights": None,  # they are among the weights
        "device": "cpu",
    }
    try:
        return kind(**options)
    except (TypeError, ValueError) as error:
        raise ComparisonError(f"{file} is not a diffusion policy's: {error}") from error
