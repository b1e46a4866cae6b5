"""What studies of rules share: the rules themselves, and rows that are saved as they come."""

import csv
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, TypeVar

Row = TypeVar("Row", bound=tuple[Any, ...])


def rules() -> dict[str, Any]:
    """What happens to gradients that meet; nobody explores."""
    from aicon_torch import NullspaceProjection, SteepestPath, Sum

    return {
        "sum": Sum(),
        "projection": NullspaceProjection(temperature=None, exploration=None),
        "projection, softmax": NullspaceProjection(exploration=None),
        "softmax sum": NullspaceProjection(projector="none", exploration=None),
        "steepest path": SteepestPath(),
    }


def save_as_they_come(
    path: Path, fields: Sequence[str], batches: Iterable[Sequence[Row]]
) -> list[Row]:
    """Write a table whose rows take long, some at a time, and return them all."""
    rows: list[Row] = []
    with path.open("w", newline="") as file:
        table = csv.writer(file)
        table.writerow(fields)
        for batch in batches:
            rows += batch
            table.writerows(batch)
            file.flush()
    return rows
