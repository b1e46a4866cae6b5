"""The formats in which LeRobot has saved diffusion policies, read as today's.

| | features in `config.json` | normalisation in `config.json` | its statistics |
|---|---|---|---|
| until 2024 | `input_shapes`, ... | `input_normalization_modes`, ... | among the weights |
| until 2025 | `input_features`, ... | `normalization_mapping` | among the weights |
| since | `input_features`, ... | `normalization_mapping` | in files of the processors |
"""

from dataclasses import fields
from itertools import product
from pathlib import Path
from typing import Any

from torch import Tensor

from aicon_baselines.agents.diffusion.lerobot_names import (
    FEATURE_TYPES,
    describe_features,
    import_lerobot,
)
from aicon_baselines.evaluation.errors import ComparisonError

Shapes = dict[str, tuple[int, ...]]
"""The shape of each feature, by name."""

Statistics = dict[str, dict[str, Tensor]]
"""For each feature its `min` and `max`, or `mean` and `std`."""

# Options of versions other than the installed one, and without a meaning here.
_IGNORED = {"type", "gradient_checkpointing", "pretrained_revision", "use_peft", "device"}

# Options that are read here, whatever the format calls them.
_SIDES = ("input", "output")
_REPLACED = {
    f"{side}_{suffix}"
    for side, suffix in product(_SIDES, ("shapes", "features", "normalization_modes"))
}

# What the layers of the old formats that normalise are called.
_NORMALIZATION_LAYERS = ("normalize_inputs.", "normalize_targets.", "unnormalize_outputs.")


def read_shapes(content: dict[str, Any], side: str) -> Shapes:
    """Return the shapes of the inputs or outputs, in either format of the configuration.

    Args:
        content: The content of `config.json`.
        side: "input" or "output".
    """
    if f"{side}_shapes" in content:
        return {name: tuple(shape) for name, shape in content[f"{side}_shapes"].items()}

    features = content.get(f"{side}_features") or {}
    return {name: tuple(feature["shape"]) for name, feature in features.items()}


def split_statistics(
    weights: dict[str, Tensor], features: Shapes
) -> tuple[dict[str, Tensor], Statistics]:
    """Separate the network's weights from the statistics that old formats keep among them."""
    network_weights = {}
    for key, value in weights.items():
        if not key.startswith(_NORMALIZATION_LAYERS):
            network_weights[key] = value

    statistics: Statistics = {}
    for name, layer in product(features, _NORMALIZATION_LAYERS):
        buffer = f"{layer}buffer_{name.replace('.', '_')}."
        found = _select_buffer(weights, buffer)
        if found:
            statistics[name] = found

    return network_weights, statistics


def build_config(file: Path, content: dict[str, Any], statistics: Statistics) -> Any:
    """Build LeRobot's configuration from the content of a file of any version.

    Args:
        file: The file, for errors.
        content: What it holds.
        statistics: What `split_statistics` found: it tells what was normalised, and how, where the
            file does not.

    Returns:
        LeRobot's `DiffusionConfig`.

    Raises:
        ComparisonError: Where LeRobot does not know an option, or rejects a value.
    """
    config_class: Any = import_lerobot("policies.diffusion.configuration_diffusion").DiffusionConfig

    # 1. Take what means the same in all formats.
    options = _common_options(content)
    known = {field.name for field in fields(config_class)}
    unknown = sorted(options.keys() - known)
    if unknown:
        raise ComparisonError(
            f"{file} has options that the installed LeRobot does not know: {', '.join(unknown)}; "
            "save the policy with the version that make install brings"
        )

    # 2. Translate the rest.
    options["input_features"] = describe_features(read_shapes(content, "input"))
    options["output_features"] = describe_features(read_shapes(content, "output"))
    options["normalization_mapping"] = _normalization_modes(content, statistics)

    # 3. Nothing is downloaded, because all weights are in the checkpoint.
    options["pretrained_backbone_weights"] = None
    options["device"] = "cpu"

    try:
        return config_class(**options)
    except (TypeError, ValueError) as error:
        raise ComparisonError(f"{file} is not a diffusion policy's: {error}") from error


def _select_buffer(weights: dict[str, Tensor], buffer: str) -> dict[str, Tensor]:
    """Return the tensors of a buffer by their names in it, in float32."""
    selected = {}
    for key, value in weights.items():
        if key.startswith(buffer):
            selected[key.removeprefix(buffer)] = value.float()

    return selected


def _common_options(content: dict[str, Any]) -> dict[str, Any]:
    """Return the options that mean the same in all formats, with the tuples that JSON lacks."""
    options = {}
    for name, value in content.items():
        if name not in _REPLACED | _IGNORED:
            options[name] = tuple(value) if isinstance(value, list) else value

    return options


def _normalization_modes(content: dict[str, Any], statistics: Statistics) -> dict[str, Any]:
    """Return how each type of feature is normalised."""
    names = dict(content.get("normalization_mapping") or {})

    # What the old formats normalised is what they have statistics of.
    for feature, found in statistics.items():
        names[FEATURE_TYPES[feature]] = "MEAN_STD" if "mean" in found else "MIN_MAX"

    modes = import_lerobot("configs.types").NormalizationMode
    return {feature_type: modes[name] for feature_type, name in names.items()}
