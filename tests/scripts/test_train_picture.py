"""The pictures that a network learns from: drawn once, and gone on with where that was stopped."""

import argparse
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("pymunk")

import train_picture
from aicon_baselines.evaluation import ComparisonError

Drawn = list[tuple[np.ndarray, np.ndarray]]


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch) -> Drawn:
    """What would be learned from, run after run."""
    runs: Drawn = []

    def look(pictures: Any, poses: Any, folder: Path, arguments: argparse.Namespace) -> None:
        runs.append((np.array(pictures), np.array(poses)))

    monkeypatch.setattr(train_picture, "train", look)
    return runs


def run(folder: Path, **options: int) -> None:
    usual = {"pictures": 20, "side": 24, "steps": 1}
    train_picture.run(argparse.Namespace(**usual | options, out=folder / "weights.pt"))


@pytest.mark.parametrize("lost", ["poses.npy", "half of both", "drawn.json"])
def test_what_was_stopped_is_drawn_to_its_end(lost: str, drawn: Drawn, tmp_path: Path) -> None:
    run(tmp_path)
    folder = tmp_path / "weights.training"
    if lost == "half of both":
        for name in ("pictures.npy", "poses.npy"):
            np.load(folder / name, mmap_mode="r+")[10:] = 0
    else:
        (folder / lost).unlink()

    run(tmp_path)
    (pictures, poses), (again, poses_again) = drawn
    assert pictures.std() > 1.0 and poses.any(axis=-1).all()
    np.testing.assert_array_equal(again, pictures)
    np.testing.assert_array_equal(poses_again, poses)


@pytest.mark.parametrize(("option", "value"), [("pictures", 30), ("side", 48)])
def test_other_pictures_are_drawn_elsewhere(
    option: str, value: int, drawn: Drawn, tmp_path: Path
) -> None:
    run(tmp_path)
    with pytest.raises(ComparisonError, match=f"holds other pictures: {option} is .* {value} here"):
        run(tmp_path, **{option: value})
    assert len(drawn) == 1


@pytest.mark.parametrize(("option", "value"), [("pictures", 19), ("side", 0), ("steps", 0)])
def test_what_cannot_be_drawn_is_refused(option: str, value: int, tmp_path: Path) -> None:
    with pytest.raises(ComparisonError, match=rf"{option} must be \d+ or more, not {value}"):
        run(tmp_path, **{option: value})
    assert not any(tmp_path.iterdir())
