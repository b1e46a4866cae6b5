"""Datasets of demonstrations, checked and read into memory."""

from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aicon_baselines.agents.diffusion.feature_names import ACTION, KEYPOINTS, PIXELS, STATE
from aicon_baselines.agents.diffusion.frames import Frames
from aicon_baselines.agents.diffusion.lerobot_import import import_lerobot
from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.files import read_json

_POSITION = {"dtype": "float32", "shape": (2,), "names": ["x", "y"]}
_COORDINATES = [f"{axis}{i}" for i, axis in product(range(8), "xy")]
_KEYPOINTS = {"dtype": "float32", "shape": (16,), "names": _COORDINATES}
_PIXELS = {"dtype": "image", "shape": (96, 96, 3), "names": ["height", "width", "channel"]}

FEATURES: dict[str, dict[str, Any]] = {
    STATE: _POSITION,
    KEYPOINTS: _KEYPOINTS,
    PIXELS: _PIXELS,
    ACTION: _POSITION,
}
"""What a dataset of demonstrations can consist of, as LeRobot describes it."""


def read_frames(folder: Path, observation: str) -> Frames:
    """Read a dataset into memory.

    Args:
        folder: Folder of the dataset.
        observation: One of `OBSERVATIONS`, besides the pusher's position.

    Raises:
        ComparisonError: Where the folder holds no dataset, or one with other features.
    """
    lerobot_dataset = import_lerobot("datasets.lerobot_dataset")
    names = [STATE, KEYPOINTS if observation == "keypoints" else PIXELS, ACTION]
    _check_features(folder, names, observation)
    dataset: Any = lerobot_dataset.LeRobotDataset(
        f"local/{folder.name}", root=folder, video_backend="pyav"
    )

    # Frames of an episode follow each other: where the number changes, another one begins.
    numbers = np.array(dataset.hf_dataset.with_format("numpy")["episode_index"][:])
    starts = np.flatnonzero(np.diff(numbers.astype(np.int64), prepend=-1))
    lengths = np.diff(starts, append=len(numbers))

    return Frames(
        columns={name: _read_column(dataset, name) for name in names},
        first=np.repeat(starts, lengths),
        last=np.repeat(starts + lengths - 1, lengths),
        statistics=dataset.meta.stats,
        features={name: dataset.meta.features[name] for name in names},
    )


def _check_features(folder: Path, names: list[str], observation: str) -> None:
    """Reject a folder without a dataset that has these features."""
    hint = f"record one: python scripts/collect_demos.py --observe {observation} --out FOLDER"
    info = folder / "meta" / "info.json"
    if not info.exists():
        raise ComparisonError(f"{folder} is no LeRobotDataset, meta/info.json is missing; {hint}")

    features = read_json(info).get("features", {})
    for name in names:
        expected = FEATURES[name]["shape"]
        shape = tuple(features.get(name, {}).get("shape", ()))

        is_picture = name == PIXELS and len(shape) == 3
        if shape != expected and not is_picture:
            raise ComparisonError(
                f"{folder} has {name!r} of shape {shape or None}, expected {expected}; "
                f"its features: {', '.join(features)}; {hint}"
            )


def _read_column(dataset: Any, name: str) -> NDArray[Any]:
    if name == PIXELS:
        return _read_pictures(dataset)

    # Read from the table itself, which is much faster than frame by frame.
    rows = dataset.hf_dataset.with_format("numpy")[name][:]
    return np.stack(rows).astype(np.float32)


def _read_pictures(dataset: Any) -> NDArray[np.uint8]:
    """Read all pictures (N, 3, height, width); LeRobot gives them as float32 in [0, 1]."""
    pictures = []
    for i in range(len(dataset)):
        picture = np.asarray(dataset[i][PIXELS])
        pictures.append((picture * 255.0).round().astype(np.uint8))

    return np.stack(pictures)
