import json
import math
import re
import shutil
import sys
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("stable_baselines3")
pytest.importorskip("pymunk")

from aicon_baselines.agents.registry import factory, import_sb3, saved_agent
from aicon_baselines.evaluation import ComparisonError


def edit(folder: Path, **values: Any) -> None:
    path = folder / "config.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | values))


def edit_statistics(folder: Path, **values: Any) -> None:
    path = folder / "statistics.json"
    content = json.loads(path.read_text())
    content["readings"]["agent_pos"] |= values
    path.write_text(json.dumps(content))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            lambda folder: shutil.rmtree(folder),
            "has no config.json; save an agent there: python scripts/train_sb3.py",
        ),
        (
            lambda folder: (folder / "agent.zip").unlink(),
            "has no agent.zip; copy the whole folder",
        ),
        (
            lambda folder: (folder / "statistics.json").unlink(),
            "has no statistics.json; copy the whole folder",
        ),
        (
            lambda folder: (folder / "config.json").write_text("{}"),
            "config.json does not describe an agent",
        ),
        (
            lambda folder: (folder / "agent.zip").write_text("no zip"),
            "agent.zip is not an agent of PPO",
        ),
        (
            lambda folder: (folder / "statistics.json").write_text("{}"),
            "statistics.json holds no statistics of this agent ('readings')",
        ),
        (
            lambda folder: edit_statistics(folder, mean=[math.nan, 0.0]),
            "statistics.json holds no statistics of this agent (a number that is not finite)",
        ),
        (
            lambda folder: edit_statistics(folder, var=[1.0, -1.0]),
            "statistics.json holds no statistics of this agent (variances [1.0, -1.0]",
        ),
        (
            lambda folder: edit(folder, reach=-1.0),
            "config.json: reach must be positive, or None, not -1.0",
        ),
        (
            lambda folder: edit(folder, algorithm="dqn"),
            "config.json: unknown algorithm 'dqn'; valid algorithms: ppo",
        ),
        (
            lambda folder: edit(folder, algorithm="sac"),
            "agent.zip is not an agent of SAC",
        ),
        (
            lambda folder: edit(folder, task="nav2d"),
            "was trained for 'nav2d', not 'pusht'. Compare it with --task nav2d",
        ),
    ],
)
def test_a_folder_that_is_no_agent_is_an_error(
    change: Any, message: str, agent_folders: dict[tuple[str, str], Path], tmp_path: Path
) -> None:
    folder = shutil.copytree(agent_folders["pusht", "ppo"], tmp_path / "agent")
    change(folder)
    with pytest.raises(ComparisonError, match=re.escape(message)):
        saved_agent("pusht", folder)


def test_a_missing_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    package = "aicon_baselines.agents.sb3"
    for name in [name for name in sys.modules if name.startswith(package)]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "stable_baselines3", None)

    with pytest.raises(ComparisonError, match=r"pip install 'aicon-torch\[sb3\]'"):
        import_sb3()
    assert callable(factory("nav2d", "aicon"))  # the others do not need it
