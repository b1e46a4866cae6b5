"""Work goes on only in a folder that was begun with the same configuration."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from aicon_baselines.evaluation.errors import ComparisonError


def check_same_config(
    folder: Path, content: str, saved: Mapping[str, Any], wanted: Mapping[str, Any]
) -> None:
    """Reject a folder that holds something else than what is wanted.

    Args:
        folder: The folder.
        content: What it holds then, for the error: "another agent".
        saved: The options that its content was made with.
        wanted: The options that have to be the same there.

    Raises:
        ComparisonError: With all options that differ.
    """
    differences = []
    for name, here in wanted.items():
        there = saved.get(name)
        if there != here:
            differences.append(f"{name} is {there} there and {here} here")

    if differences:
        raise ComparisonError(
            f"{folder} holds {content}: {'; '.join(differences)}. Choose another folder."
        )
