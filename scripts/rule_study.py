"""What studies of rules share: the rules themselves, and a table that is filled as they run."""

import csv
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, TypeVar, get_type_hints

from aicon_baselines.evaluation.errors import ComparisonError

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


def fill(
    path: Path,
    kind: type[Row],
    wanted: Sequence[tuple[Any, ...]],
    measure: Callable[..., Sequence[Row]],
) -> list[Row]:
    """Measure what a table lacks, row by row as it comes, and return the rows that are wanted.

    A study that was stopped goes on where it was; rows of other settings stay beside.

    Args:
        path: The table.
        kind: The named tuple of a row, which begins with what was wanted.
        wanted: What to measure: the beginning of a row, or of several.
        measure: From one of these to its rows.

    Raises:
        ComparisonError: If the table is of another study.
    """
    from tqdm import tqdm

    size = len(wanted[0])
    known: dict[tuple[Any, ...], list[Row]] = {}
    for row in _read(path, kind):
        known.setdefault(row[:size], []).append(row)

    with path.open("a", newline="") as file:
        table = csv.writer(file)
        if file.tell() == 0:
            table.writerow(get_type_hints(kind))
        for begin in tqdm(wanted, unit="cell"):
            if begin not in known:
                known[begin] = list(measure(*begin))
                table.writerows(known[begin])
                file.flush()
    return [row for begin in wanted for row in known[begin]]


def _read(path: Path, kind: type[Row]) -> list[Row]:
    """The rows of a table, none where there is no table yet."""
    if not path.exists():
        return []
    columns = get_type_hints(kind)
    with path.open(newline="") as file:
        table = csv.DictReader(file)
        if table.fieldnames != list(columns):
            raise ComparisonError(
                f"{path} has the columns {table.fieldnames}, expected {list(columns)}: "
                "name another folder with --out."
            )
        return [kind(*(read(row[name]) for name, read in columns.items())) for row in table]
