"""The table of a study: rows are saved as they come, and a study that was stopped goes on.

A row is a named tuple, whose fields are the columns.
"""

import csv
from collections import defaultdict
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, TypeVar, get_type_hints

from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.evaluation.recording import track

Row = TypeVar("Row", bound=tuple[Any, ...])


def read(path: Path, kind: type[Row]) -> list[Row]:
    """The rows of a table; none where there is no table yet.

    Args:
        path: The table.
        kind: The named tuple of a row.

    Raises:
        ComparisonError: If the table is of another study.
    """
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
        return [kind(*(_value(row[name], columns[name]) for name in columns)) for row in table]


def _value(text: str, kind: type) -> Any:
    """What a cell says; of a truth value its name."""
    return text == str(True) if kind is bool else kind(text)


def write(path: Path, *rows: Any) -> None:
    """Add rows to a table, which begins with the names of its columns."""
    with path.open("a", newline="") as file:
        table = csv.writer(file)
        if rows and file.tell() == 0:
            table.writerow(rows[0]._fields)
        table.writerows(rows)


def fill(
    path: Path,
    kind: type[Row],
    wanted: Sequence[tuple[Any, ...]],
    measure: Callable[..., Sequence[Row]],
    label: str = "cells",
) -> list[Row]:
    """Measure what a table lacks, saved as it comes, and return the rows that are wanted.

    A study that was stopped goes on where it was; rows of other settings stay beside.

    Args:
        path: The table.
        kind: The named tuple of a row, which begins with what was wanted.
        wanted: What to measure: the beginning of a row, or of several.
        measure: From one of these to its rows.
        label: What the progress bar says.

    Raises:
        ComparisonError: If the table is of another study.
    """
    return fill_in_groups(path, kind, wanted, lambda group: measure(*group[0]), 1, label)


def fill_in_groups(
    path: Path,
    kind: type[Row],
    wanted: Sequence[tuple[Any, ...]],
    measure: Callable[[Sequence[tuple[Any, ...]]], Sequence[Row]],
    size: int,
    label: str = "cells",
) -> list[Row]:
    """The same, where up to so many are measured together, to all of their rows."""
    length = len(wanted[0]) if wanted else 0
    known = defaultdict(list)
    for row in read(path, kind):
        known[row[:length]].append(row)

    path.parent.mkdir(parents=True, exist_ok=True)
    missing = [begin for begin in dict.fromkeys(wanted) if begin not in known]
    for first in track(range(0, len(missing), size), label):
        rows = measure(missing[first : first + size])
        write(path, *rows)
        for row in rows:
            known[row[:length]].append(row)
    return [row for begin in wanted for row in known[begin]]
