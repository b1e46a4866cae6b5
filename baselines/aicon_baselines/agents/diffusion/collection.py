"""Recording demonstrations, and going on with it."""

import shutil
from collections.abc import Callable, Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from aicon_baselines.agents.diffusion.configs import CHUNK_SIZE, AnyRecording
from aicon_baselines.agents.diffusion.dataset import write_dataset
from aicon_baselines.agents.diffusion.demonstrations import Demonstration, record_chunk
from aicon_baselines.agents.diffusion.lerobot_names import import_lerobot
from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.files import check_same_config, only_writer, read_json, replacing, write_json

RECORDING = "recording.json"
"""File in a dataset's folder that says how it was recorded."""


def collect(
    config: AnyRecording,
    folder: Path,
    on_recorded: Callable[[int], None] | None = None,
) -> None:
    """Record demonstrations and write them as a `LeRobotDataset`.

    Chunks go to `<folder>.chunks` as they are recorded; the same call goes on there after a stop.
    The dataset is written at the end, because an unfinished one cannot be read.

    Args:
        config: What to record.
        folder: Folder of the dataset.
        on_recorded: Called with the number of successful episodes of each chunk, also of those
            already there.

    Raises:
        ComparisonError: Where the folder holds something else, another process records there, or
            LeRobot is missing.
    """
    import_lerobot("datasets.lerobot_dataset")

    # 1. There is nothing to do where the dataset is finished.
    if folder.exists():
        _check_same_recording(config, folder)
        if on_recorded is not None:
            on_recorded(config.episodes)
        return

    # 2. Begin, or go on with, what is recorded beside it.
    chunks = folder.with_name(folder.name + ".chunks")
    with only_writer(chunks):
        if (chunks / RECORDING).exists():
            _check_same_recording(config, chunks)
        else:
            write_json(chunks / RECORDING, asdict(config))
        files = _record_missing_chunks(config, chunks, on_recorded)

        # 3. Write the dataset beside its place first, so that the folder is always a whole one.
        temporary = folder.with_name(folder.name + ".tmp")
        shutil.rmtree(temporary, ignore_errors=True)
        write_dataset(config, _load_chunks(files), temporary, name=folder.name)
        write_json(temporary / RECORDING, asdict(config))
        temporary.replace(folder)
        shutil.rmtree(chunks)


def _record_missing_chunks(
    config: AnyRecording, chunks: Path, on_recorded: Callable[[int], None] | None
) -> list[Path]:
    """Record until there are enough successes; return the files that hold them."""
    files: list[Path] = []
    recorded = 0

    while recorded < config.episodes:
        index = len(files)
        tried = index * CHUNK_SIZE

        # A teacher that hardly ever succeeds would go on for ever.
        if tried > 10 * config.episodes:
            raise ComparisonError(
                f"{recorded} of {tried} demonstrations were successful: "
                "take a condition without noise, or a longer horizon"
            )

        # What a stopped run has recorded is there already.
        file = chunks / f"{index:06d}.npz"
        if not file.exists():
            _save_chunk(record_chunk(config, index), file)
        files.append(file)

        successes = _count_episodes(file)
        if on_recorded is not None:
            on_recorded(min(successes, config.episodes - recorded))
        recorded += successes

    return files


def _save_chunk(episodes: list[Demonstration], file: Path) -> None:
    """Write an array for each episode i and feature as "i/feature"; a kill leaves no part of it."""
    arrays: dict[str, Any] = {"episodes": np.array(len(episodes))}
    for i, episode in enumerate(episodes):
        for name, values in episode.items():
            arrays[f"{i}/{name}"] = values

    with replacing(file) as place:
        np.savez_compressed(place, **arrays)


def _count_episodes(file: Path) -> int:
    with np.load(file) as arrays:
        return int(arrays["episodes"])


def _load_chunks(files: list[Path]) -> Iterator[Demonstration]:
    """Yield the episodes of all chunks, one at a time."""
    for file in files:
        with np.load(file) as arrays:
            for i in range(int(arrays["episodes"])):
                yield _select_episode(arrays, i)


def _select_episode(arrays: Any, i: int) -> Demonstration:
    episode = {}
    for key in arrays.files:
        number, _, name = key.partition("/")
        if number == str(i):
            episode[name] = arrays[key]

    return episode


def _check_same_recording(config: AnyRecording, folder: Path) -> None:
    file = folder / RECORDING
    saved = read_json(file) if file.exists() else {}
    check_same_config(folder, "other demonstrations", saved, asdict(config))
