"""Demonstrations recorded and written as a `LeRobotDataset`."""

import json
import shutil
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from aicon_baselines.agents.diffusion.dataset import FEATURES
from aicon_baselines.agents.diffusion.demonstrations import CHUNK, Demonstration, Recording, record_chunk
from aicon_baselines.agents.diffusion.features import ACTION, KEYPOINTS, PIXELS, STATE
from aicon_baselines.agents.diffusion.installed import import_lerobot
from aicon_baselines.evaluation.errors import ComparisonError

FPS = 10
TASK = "Push the T onto its target."
RECORDING = "recording.json"
"""File in a dataset's folder that says how it was recorded."""


def collect(recording: Recording, folder: Path, on_recorded: Callable[[int], None] = lambda count: None) -> None:
    """Record demonstrations and write them as a `LeRobotDataset`.

    Chunks go to `<folder>.chunks` as they are recorded; the same call goes on there after a stop. The dataset is
    written at the end, because an unfinished one cannot be read.

    Args:
        recording: What to record; an error if the folder holds something else.
        folder: Folder of the dataset.
        on_recorded: Called with the number of successful episodes of each chunk, also of those already there.
    """
    import_lerobot("datasets.lerobot_dataset")
    from datasets import disable_progress_bars

    disable_progress_bars()  # one for each episode with pictures
    if folder.exists():
        _same_recording(recording, folder / RECORDING)
        on_recorded(recording.episodes)
        return
    chunks = folder.with_name(folder.name + ".chunks")
    chunks.mkdir(parents=True, exist_ok=True)
    if (chunks / RECORDING).exists():
        _same_recording(recording, chunks / RECORDING)
    else:
        (chunks / RECORDING).write_text(_describe(recording))
    _write(recording, _recorded(recording, chunks, on_recorded), folder)
    shutil.rmtree(chunks)


def _recorded(recording: Recording, chunks: Path, on_recorded: Callable[[int], None]) -> list[Path]:
    """Record the chunks that are missing; return the files that hold the episodes asked for."""
    files: list[Path] = []
    count, index = 0, 0
    while count < recording.episodes:
        if index * CHUNK > 10 * recording.episodes:
            raise ComparisonError(
                f"{count} of {index * CHUNK} demonstrations were successful: lower the noise or raise the horizon"
            )
        file = chunks / f"{index:06d}.npz"
        if not file.exists():
            _save(record_chunk(recording, index), file)
        with np.load(file) as content:
            found = int(content["episodes"])
        on_recorded(min(found, recording.episodes - count))
        files.append(file)
        count, index = count + found, index + 1
    return files


def _save(episodes: list[Demonstration], file: Path) -> None:
    arrays = {f"{i}/{name}": value for i, episode in enumerate(episodes) for name, value in episode.items()}
    temporary = file.with_suffix(".tmp")
    with temporary.open("wb") as stream:
        np.savez_compressed(stream, episodes=np.array(len(episodes)), **arrays)  # type: ignore[arg-type]
    temporary.replace(file)


def _write(recording: Recording, files: list[Path], folder: Path) -> None:
    """Write the dataset beside its folder first, so that a folder is always a whole dataset."""
    temporary = folder.with_name(folder.name + ".tmp")
    shutil.rmtree(temporary, ignore_errors=True)
    offered = {"keypoints": [KEYPOINTS], "pixels": [PIXELS]}
    names = [STATE, *(name for each in recording.observations for name in offered[each]), ACTION]
    dataset: Any = import_lerobot("datasets.lerobot_dataset").LeRobotDataset.create(
        repo_id=f"local/{folder.name}",
        fps=FPS,
        root=temporary,
        features={name: FEATURES[name] for name in names},
        use_videos=False,
    )
    missing = recording.episodes
    for file in files:
        with np.load(file) as content:
            for i in range(min(int(content["episodes"]), missing)):
                episode = {name: content[f"{i}/{name}"] for name in names}
                for t in range(len(episode[ACTION])):
                    dataset.add_frame({name: value[t] for name, value in episode.items()} | {"task": TASK})
                dataset.save_episode()
                missing -= 1
    dataset.finalize()
    (temporary / RECORDING).write_text(_describe(recording))
    temporary.replace(folder)


def _describe(recording: Recording) -> str:
    return json.dumps(asdict(recording), indent=2) + "\n"


def _same_recording(recording: Recording, file: Path) -> None:
    there = json.loads(file.read_text()) if file.exists() else {}
    here = json.loads(_describe(recording))
    differing = [name for name in here if there.get(name) != here[name]]
    if differing:
        details = "; ".join(f"{name} is {there.get(name)} there and {here[name]} here" for name in differing)
        raise ComparisonError(f"{file.parent} holds other demonstrations: {details}. Choose another folder.")
