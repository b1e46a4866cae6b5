"""What is downloaded is pinned to a commit, and runs no code."""

import json
from pathlib import Path

import pytest

from aicon_baselines.agents.diffusion.checkpoint import check_steps
from aicon_baselines.agents.diffusion.hub import locate
from aicon_baselines.evaluation import ComparisonError

CHECKPOINTS = Path(__file__).parents[3] / "baselines" / "checkpoints"


def test_a_name_without_a_commit_is_not_downloaded() -> None:
    message = r"needs the commit.*owner/name@COMMIT.*huggingface.co/owner/name/commits/main"
    with pytest.raises(ComparisonError, match=message):
        locate("owner/name")


@pytest.mark.parametrize("source", ["owner", "owner/name@main", "owner/name@0123", "a/b/c"])
def test_what_is_no_pinned_name_is_refused(source: str) -> None:
    with pytest.raises(ComparisonError, match="no OWNER/REPOSITORY@COMMIT of the hub"):
        locate(source)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (
            {"steps": [{"class": "subprocess.Popen", "config": {"args": "true"}}]},
            "none of LeRobot's, but code to run: .*subprocess.Popen",
        ),
        ({"steps": ["subprocess.Popen"]}, "none of LeRobot's"),
        ({}, "lists no steps"),
    ],
)
def test_a_processor_with_code_is_refused(tmp_path: Path, content: object, message: str) -> None:
    path = tmp_path / "policy_preprocessor.json"
    path.write_text(json.dumps(content))
    with pytest.raises(ComparisonError, match=message):
        check_steps(path)


def test_the_processors_that_we_ship_are_lerobots_own() -> None:
    paths = list(CHECKPOINTS.glob("*/policy_*processor.json"))
    assert len(paths) == 2
    for path in paths:
        check_steps(path)
