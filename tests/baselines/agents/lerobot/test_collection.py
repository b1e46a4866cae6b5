"""What is recorded is what LeRobot, and our training, reads."""

import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("lerobot")

from lerobot.datasets.lerobot_dataset import LeRobotDataset

from aicon_baselines.agents.diffusion import collection
from aicon_baselines.agents.diffusion.collection import collect
from aicon_baselines.agents.diffusion.configs import RecordingConfig
from aicon_baselines.agents.diffusion.dataset import read_frames
from aicon_baselines.agents.diffusion.demonstrations import record_chunk
from aicon_baselines.evaluation import ComparisonError

SetChunkSize = Callable[[pytest.MonkeyPatch, int], None]


def test_windows_are_those_of_lerobot(demos: Path) -> None:
    frames = read_frames(demos, "keypoints")
    reference = LeRobotDataset(
        "local/data", root=demos, delta_timestamps={"action": [-0.1, 0.0, 0.1]}
    )
    assert len(frames) == len(reference)
    assert len(np.unique(frames.first)) == reference.num_episodes == 3

    end = int(frames.last[0])
    for i in (0, 5, end, end + 1, len(frames) - 1):
        offsets = {"action": [-1, 0, 1], "observation.state": [0]}
        values, paddings = frames.windows(np.array([i]), offsets)
        expected = {name: value for name, value in reference[i].items() if name != "task"}
        assert np.array_equal(values["action"][0], expected["action"].numpy())
        assert np.array_equal(paddings["action"][0], expected["action_is_pad"].numpy())
        state = values["observation.state"][0, 0]
        assert np.array_equal(state, expected["observation.state"].numpy())


def test_pictures_are_those_that_were_recorded(
    demos: Path,
    quick: dict[str, Any],
    chunks_of: SetChunkSize,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    chunks_of(monkeypatch, 2)
    recorded = record_chunk(RecordingConfig(**quick, observations=("pixels",)), 0)[0]
    pictures = read_frames(demos, "pixels").columns["observation.image"]
    expected = np.moveaxis(recorded["observation.image"], -1, 1)
    assert np.array_equal(pictures[: len(expected)], expected)


def test_recording_goes_on_where_it_stopped(
    quick: dict[str, Any],
    chunks_of: SetChunkSize,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    chunks_of(monkeypatch, 1)
    config = RecordingConfig(**quick)
    folder = tmp_path / "demos"
    recorded: list[int] = []

    def record_or_stop(config: RecordingConfig, index: int) -> Any:
        recorded.append(index)
        if len(recorded) == 2:
            raise KeyboardInterrupt
        return record_chunk(config, index)

    monkeypatch.setattr(collection, "record_chunk", record_or_stop)
    with pytest.raises(KeyboardInterrupt):
        collect(config, folder)
    assert not folder.exists()

    message = "holds other demonstrations: near is 0.0 there and 0.5 here"
    with pytest.raises(ComparisonError, match=message):
        collect(RecordingConfig(**quick, near=0.5), folder)

    counts: list[int] = []
    collect(config, folder, counts.append)
    assert recorded == [0, 1, 1, 2] and sum(counts) == 3
    assert len(np.unique(read_frames(folder, "keypoints").first)) == 3

    collect(config, folder)  # nothing is missing
    assert recorded == [0, 1, 1, 2]

    message = "other demonstrations: episodes is 3 there and 4 here. Choose another"
    with pytest.raises(ComparisonError, match=message):
        collect(RecordingConfig(**quick | {"episodes": 4}), folder)


def rename_feature(folder: Path, old: str, new: str) -> None:
    path = folder / "meta" / "info.json"
    path.write_text(path.read_text().replace(f'"{old}"', f'"{new}"'))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            lambda folder: shutil.rmtree(folder),
            "is no LeRobotDataset, meta/info.json is missing; record one: python",
        ),
        (
            lambda folder: rename_feature(folder, "observation.environment_state", "keys"),
            "has no 'observation.environment_state'",
        ),
        (
            lambda folder: rename_feature(folder, "action", "command"),
            "has no 'action'; its features",
        ),
    ],
)
def test_another_dataset_is_an_error(
    change: Any, message: str, demos: Path, tmp_path: Path
) -> None:
    folder = shutil.copytree(demos, tmp_path / "demos")
    change(folder)
    with pytest.raises(ComparisonError, match=re.escape(message)):
        read_frames(folder, "keypoints")
