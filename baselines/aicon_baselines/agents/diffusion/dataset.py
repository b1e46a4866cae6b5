"""Datasets of demonstrations, checked and read into memory."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aicon_baselines.agents.diffusion.features import ACTION, KEYPOINTS, PIXELS, STATE
from aicon_baselines.agents.diffusion.installed import import_lerobot
from aicon_baselines.evaluation.errors import ComparisonError

_POSITION = {"dtype": "float32", "shape": (2,), "names": ["x", "y"]}
FEATURES: dict[str, dict[str, Any]] = {
    STATE: _POSITION,
    KEYPOINTS: {"dtype": "float32", "shape": (16,), "names": [f"{axis}{i}" for i in range(8) for axis in "xy"]},
    PIXELS: {"dtype": "image", "shape": (96, 96, 3), "names": ["height", "width", "channel"]},
    ACTION: _POSITION,
}
"""What a dataset of demonstrations can consist of, as LeRobot describes it."""


@dataclass(frozen=True)
class Frames:
    """A dataset of N frames in memory.

    Attributes:
        columns: Arrays (N, ...) by the dataset's names; pictures as uint8 (N, 3, height, width).
        first: (N,), index of the first frame of each frame's episode.
        last: (N,), index of its last frame.
        statistics: Those of the dataset, for the normalisation.
        features: The features of the dataset, as LeRobot describes them.
    """

    columns: dict[str, NDArray[Any]]
    first: NDArray[np.int64]
    last: NDArray[np.int64]
    statistics: dict[str, Any]
    features: dict[str, dict[str, Any]]

    def __len__(self) -> int:
        """Count the frames."""
        return len(self.first)

    def windows(
        self, index: NDArray[np.int64], offsets: dict[str, list[int]]
    ) -> tuple[dict[str, NDArray[Any]], dict[str, NDArray[np.bool_]]]:
        """Return the values (B, T, ...) at these frames (B,) plus each column's offsets (T,), and what is padding.

        As in LeRobot, an episode's first frame stands for what would lie before it, and its last for what lies after.
        """
        values, padded = {}, {}
        for name, steps in offsets.items():
            wanted = index[:, None] + np.array(steps)
            inside = np.clip(wanted, self.first[index][:, None], self.last[index][:, None])
            values[name], padded[name] = self.columns[name][inside], wanted != inside
        return values, padded


def read(folder: Path, observation: str) -> Frames:
    """Read a dataset into memory.

    Args:
        folder: Folder of the dataset.
        observation: One of `OBSERVATIONS`, besides the pusher's position.

    Returns:
        The frames; a folder that is no dataset, or one with other features, is an error.
    """
    lerobot = import_lerobot("datasets.lerobot_dataset")
    record = f"record one: python scripts/collect_demos.py --observe {observation} --out FOLDER"
    if not (folder / "meta" / "info.json").exists():
        raise ComparisonError(f"{folder} is no LeRobotDataset, meta/info.json is missing; {record}")
    names = [STATE, KEYPOINTS if observation == "keypoints" else PIXELS, ACTION]
    features = json.loads((folder / "meta" / "info.json").read_text()).get("features", {})
    for name in names:
        expected = FEATURES[name]["shape"]
        shape = tuple(features.get(name, {}).get("shape", ()))
        if shape != expected and not (name == PIXELS and len(shape) == 3):
            raise ComparisonError(
                f"{folder} has {name!r} of shape {shape or None}, expected {expected}; its features: "
                f"{', '.join(features)}; {record}"
            )
    dataset: Any = lerobot.LeRobotDataset(f"local/{folder.name}", root=folder, video_backend="pyav")
    episode = np.array(dataset.hf_dataset.with_format("numpy")["episode_index"][:]).astype(np.int64)
    starts = np.flatnonzero(np.diff(episode, prepend=-1))
    lengths = np.diff(starts, append=len(episode))
    return Frames(
        columns={name: _column(dataset, name) for name in names},
        first=np.repeat(starts, lengths),
        last=np.repeat(starts + lengths - 1, lengths),
        statistics=dataset.meta.stats,
        features={name: dataset.meta.features[name] for name in names},
    )


def _column(dataset: Any, name: str) -> NDArray[Any]:
    if name == PIXELS:
        pictures = (np.asarray(dataset[i][name]) for i in range(len(dataset)))  # float32 in [0, 1], channels first
        return np.stack([(picture * 255.0).round().astype(np.uint8) for picture in pictures])
    return np.stack(dataset.hf_dataset.with_format("numpy")[name][:]).astype(np.float32)
