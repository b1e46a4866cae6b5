"""What is downloaded is pinned to a commit."""

import pytest

from aicon_baselines.agents.diffusion.hub import locate
from aicon_baselines.evaluation import ComparisonError


def test_a_name_without_a_commit_is_not_downloaded() -> None:
    message = r"needs the commit.*owner/name@COMMIT.*huggingface.co/owner/name/commits/main"
    with pytest.raises(ComparisonError, match=message):
        locate("owner/name")


@pytest.mark.parametrize("source", ["owner", "owner/name@main", "owner/name@0123", "a/b/c"])
def test_what_is_no_pinned_name_is_refused(source: str) -> None:
    with pytest.raises(ComparisonError, match="no OWNER/REPOSITORY@COMMIT of the hub"):
        locate(source)
