"""A policy of one's own in the comparison, named by the function that builds it."""

import pickle
import sys
from pathlib import Path

import pytest

from aicon_baselines.agents.registry import own_policy
from aicon_baselines.cli.main import main
from aicon_baselines.evaluation import ComparisonError
from aicon_baselines.evaluation.rows_file import read_rows

SOURCE = '''
import numpy as np

class Straight:
    """Heads for the target, whatever is in the way."""

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        bearing = observation["bearing"]
        return 0.5 * np.concatenate((np.cos(bearing), np.sin(bearing)), -1), None

def straight(condition):
    return Straight()
'''


@pytest.fixture
def module(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    (tmp_path / "policies_of_mine.py").write_text(SOURCE)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    return "policies_of_mine"


def test_it_is_compared_like_any_other(module: str, tmp_path: Path) -> None:
    own = f"{module}:straight"
    words = ["--policies", "aicon", own, "--episodes", "2", "--horizon", "2", "--no-compile"]
    main(["compare", "--task", "nav2d", *words, "--out", "out"])
    rows = read_rows(tmp_path / "out" / "episodes.csv")
    assert sorted({row.policy for row in rows}) == ["aicon", own]


def test_what_builds_it_goes_to_the_workers(module: str) -> None:
    build = pickle.loads(pickle.dumps(own_policy(f"{module}:straight")))
    assert callable(build("range").predict)


@pytest.mark.parametrize(
    "source",
    ["math:pi", "nowhere:straight", "policies_of_mine:crooked", "./policies_of_mine.py:straight"],
)
def test_what_is_missing_is_a_sentence(module: str, source: str) -> None:
    with pytest.raises(ComparisonError, match="expected MODULE:FUNCTION"):
        own_policy(source)
