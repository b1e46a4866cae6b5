"""What LeRobot calls things, and LeRobot itself, which is large and not always installed."""

import os
from collections.abc import Mapping
from importlib import import_module
from types import ModuleType
from typing import Any

from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.extras import pip_command

STATE = "observation.state"
"""Of the robot: in pushT (2,), the pusher's position, px."""

KEYPOINTS = "observation.environment_state"
"""Of its world: in pushT (16,), the object's keypoints x0, y0, x1, ..., px."""

PIXELS = "observation.image"
"""(3, height, width) in a policy, (height, width, 3) in a dataset."""

ACTION = "action"
"""In pushT (2,), target of the pusher's controller, px."""

SHOWN = {"keypoints": KEYPOINTS, "pixels": PIXELS}
"""What demonstrations can show of the world."""

FEATURE_TYPES = {STATE: "STATE", KEYPOINTS: "ENV", PIXELS: "VISUAL", ACTION: "ACTION"}
"""LeRobot's types of them, which choose the normalisation."""


def describe_features(shapes: Mapping[str, tuple[int, ...]]) -> dict[str, Any]:
    """Return LeRobot's descriptions of features, by name, from their shapes."""
    types = import_lerobot("configs.types")

    features = {}
    for name, shape in shapes.items():
        feature_type = types.FeatureType[FEATURE_TYPES.get(name, "STATE")]
        features[name] = types.PolicyFeature(type=feature_type, shape=shape)

    return features


def import_lerobot(module: str) -> ModuleType:
    """Import `lerobot.<module>`; without LeRobot an error says how to get it."""
    os.environ.setdefault("HF_HUB_DISABLE_TELEMETRY", "1")

    try:
        return import_module(f"lerobot.{module}")
    except ModuleNotFoundError as error:
        raise ComparisonError(
            f"{error}; diffusion policies need LeRobot, several gigabytes: "
            f"{pip_command('lerobot')}, or all that was tested with it: make install"
        ) from error
