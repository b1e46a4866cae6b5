"""Datasets of demonstrations: written by LeRobot, checked, and read into memory."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain, islice
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aicon_baselines.agents.diffusion.configs import AnyRecording
from aicon_baselines.agents.diffusion.demonstrations import Demonstration
from aicon_baselines.agents.diffusion.lerobot_names import (
    ACTION,
    PIXELS,
    SHOWN,
    STATE,
    import_lerobot,
)
from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.files import read_json
from aicon_baselines.tasks.registry import lesson_of, load


@dataclass(frozen=True)
class Frames:
    """A dataset of N frames in memory.

    Attributes:
        columns: Arrays (N, ...) by the dataset's names; pictures as uint8 (N, 3, height, width).
        first: (N,), index of the first frame of each frame's episode.
        last: (N,), index of its last frame.
        statistics: Those of the dataset, for the normalisation.
        features: The features of the dataset, as LeRobot describes them.
        fps: Frames a second.
    """

    columns: dict[str, NDArray[Any]]
    first: NDArray[np.int64]
    last: NDArray[np.int64]
    statistics: dict[str, Any]
    features: dict[str, dict[str, Any]]
    fps: int

    def __len__(self) -> int:
        """Count the frames."""
        return len(self.first)

    def windows(
        self, index: NDArray[np.int64], offsets: dict[str, list[int]]
    ) -> tuple[dict[str, NDArray[Any]], dict[str, NDArray[np.bool_]]]:
        """Return the values around frames, and which of them are padding.

        As in LeRobot, an episode's first frame stands for what would lie before it, and its last
        for what lies after.

        Args:
            index: (B,), the frames.
            offsets: For each column the T offsets to take, in frames.

        Returns:
            The values (B, T, ...) and the paddings (B, T), by column.
        """
        first, last = self.first[index], self.last[index]
        values, paddings = {}, {}

        for name, steps in offsets.items():
            wanted = index[:, None] + np.array(steps)
            available = np.clip(wanted, first[:, None], last[:, None])

            values[name] = self.columns[name][available]
            paddings[name] = wanted != available

        return values, paddings


def shuffled_batches(count: int, batch_size: int, seed: int) -> Iterator[NDArray[np.int64]]:
    """Yield indices (B,) of frames without end; each epoch is a new permutation of all of them.

    Args:
        count: Number of frames.
        batch_size: B; a batch may go over the end of an epoch.
        seed: Seed of the permutations.
    """
    rng = np.random.default_rng(seed)
    remaining: NDArray[np.int64] = np.empty(0, np.int64)

    while True:
        while len(remaining) < batch_size:
            remaining = np.concatenate([remaining, rng.permutation(count)])

        yield remaining[:batch_size]
        remaining = remaining[batch_size:]


def read_frames(folder: Path, observation: str) -> Frames:
    """Read a dataset into memory.

    Args:
        folder: Folder of the dataset.
        observation: One of `OBSERVATIONS`, besides the pusher's position.

    Raises:
        ComparisonError: Where the folder holds no dataset, or one with other features.
    """
    lerobot_dataset = import_lerobot("datasets.lerobot_dataset")
    names = [STATE, SHOWN[observation], ACTION]
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
        fps=dataset.meta.fps,
    )


def _check_features(folder: Path, names: list[str], observation: str) -> None:
    """Reject a folder without a dataset that has these features."""
    hint = f"record one: python scripts/collect_demos.py --observe {observation} --out FOLDER"
    info = folder / "meta" / "info.json"
    if not info.exists():
        raise ComparisonError(f"{folder} is no LeRobotDataset, meta/info.json is missing; {hint}")

    features = read_json(info).get("features", {})
    for name in names:
        if name not in features:
            raise ComparisonError(
                f"{folder} has no {name!r}; its features: {', '.join(features)}; {hint}"
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


def together(datasets: Sequence[Frames]) -> Frames:
    """The frames of several datasets, with the statistics of the first one.

    Raises:
        ComparisonError: If they differ in frames a second, or in the shape of a column.
    """
    first, *others = datasets
    expected = _format(first)
    for frames in others:
        if _format(frames) != expected:
            raise ComparisonError(
                "datasets that are learned from together must be alike: there is one with "
                f"{expected} and one with {_format(frames)}"
            )

    starts = np.cumsum([0, *(len(frames) for frames in datasets[:-1])])
    shifted = list(zip(datasets, starts.tolist(), strict=True))

    return replace(
        first,
        columns={
            name: np.concatenate([frames.columns[name] for frames in datasets])
            for name in first.columns
        },
        first=np.concatenate([frames.first + start for frames, start in shifted]),
        last=np.concatenate([frames.last + start for frames, start in shifted]),
    )


def _format(frames: Frames) -> dict[str, Any]:
    """What a dataset must share with those that it is learned from with."""
    return {name: values.shape[1:] for name, values in frames.columns.items()} | {"fps": frames.fps}


def write_dataset(
    config: AnyRecording, episodes: Iterable[Demonstration], folder: Path, name: str
) -> None:
    """Write as many demonstrations as are wanted as a `LeRobotDataset`.

    Args:
        config: What to write.
        episodes: The demonstrations, at least one.
        folder: Folder of the dataset, which does not exist yet.
        name: Name of the dataset.
    """
    from datasets import disable_progress_bars

    disable_progress_bars()  # one for each episode with pictures

    wanted = islice(episodes, config.episodes)
    first = next(wanted)
    dataset: Any = import_lerobot("datasets.lerobot_dataset").LeRobotDataset.create(
        repo_id=f"local/{name}",
        fps=round(1.0 / load(config.task).time_step),
        root=folder,
        features={feature: _described(values) for feature, values in first.items()},
        use_videos=False,
    )

    # Frames belong to an episode by being added before it is saved.
    words = lesson_of(config.task).words
    for episode in chain([first], wanted):
        for t in range(len(episode[ACTION])):
            frame = {feature: values[t] for feature, values in episode.items()}
            dataset.add_frame(frame | {"task": words})
        dataset.save_episode()

    dataset.finalize()


def _described(values: NDArray[Any]) -> dict[str, Any]:
    """A feature (T, ...) as LeRobot describes it."""
    shape = values.shape[1:]
    if len(shape) == 3:
        return {"dtype": "image", "shape": shape, "names": ["height", "width", "channel"]}
    return {"dtype": "float32", "shape": shape, "names": [str(i) for i in range(shape[0])]}
