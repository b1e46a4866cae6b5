"""The trained policies of the repository, and what is said where they are missing."""

from pathlib import Path

import pytest

from aicon_baselines.agents import shipped
from aicon_baselines.agents.diffusion.hub import _SOURCE
from aicon_baselines.agents.shipped import PUBLISHED_DIFFUSION, shipped_folder
from aicon_baselines.evaluation import ComparisonError

SHIPPED = [("diffusion", "pusht"), ("sb3", "pusht"), ("sb3", "nav2d")]


@pytest.mark.parametrize(("kind", "task"), SHIPPED)
def test_each_folder_tells_how_it_was_made(kind: str, task: str) -> None:
    folder = shipped_folder(kind, task)
    assert (folder / "config.json").is_file()
    assert "python scripts/train_" in (folder / "README.md").read_text()


@pytest.mark.parametrize(("kind", "task"), SHIPPED)
def test_an_installation_without_them_says_where_they_are(
    kind: str, task: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(shipped, "_CHECKPOINTS", tmp_path)
    with pytest.raises(ComparisonError, match="baselines/checkpoints/.* of the repository") as told:
        shipped_folder(kind, task)
    other = PUBLISHED_DIFFUSION if kind == "diffusion" else f"train_sb3.py --task {task}"
    assert other in str(told.value)


def test_a_task_without_a_trained_policy_is_refused() -> None:
    with pytest.raises(ComparisonError, match="no policy 'sb3' was trained for reach, only for"):
        shipped_folder("sb3", "reach")


def test_the_published_policy_is_pinned_to_a_commit() -> None:
    named = _SOURCE.fullmatch(PUBLISHED_DIFFUSION)
    assert named and named["commit"]
