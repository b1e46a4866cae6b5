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
from aicon_baselines.files import only_writer, read_text, replacing

Row = TypeVar("Row", bound=tuple[Any, ...])


def read(path: Path, kind: type[Row]) -> list[Row]:
    """The rows of a table; none where there is no table yet.

    Args:
        path: The table.
        kind: The named tuple of a row.

    Raises:
        ComparisonError: If the table is of another study, or a line is not a row; it names the
            line.
    """
    if not _whole_lines(path):
        return []

    columns = get_type_hints(kind)
    header, *lines = csv.reader(_whole_lines(path))
    if header != list(columns):
        raise ComparisonError(
            f"{path} has the columns {header}, expected {list(columns)}: "
            "name another folder with --out."
        )

    rows = []
    for number, cells in enumerate(lines, start=2):
        try:
            named = zip(cells, columns.values(), strict=True)
            rows.append(kind(*(_value(text, own) for text, own in named)))
        except ValueError as error:
            raise ComparisonError(
                f"{path}, line {number} is not a row: {cells}; without it, and all that begin as "
                "it does, it is measured again."
            ) from error
    return rows


def _whole_lines(path: Path) -> list[str]:
    """The lines of a table; a last one that is not whole was left by a writer that was killed."""
    text = read_text(path) if path.exists() else ""
    return text[: text.rfind("\n") + 1].splitlines()


def _value(text: str, kind: type) -> Any:
    """What a cell says; of a truth value its name."""
    return text == str(True) if kind is bool else kind(text)


def write(path: Path, *rows: Any) -> None:
    """Add rows to a table, which begins with the names of its columns: all of them, or none."""
    lines = _whole_lines(path)
    with replacing(path) as place, place.open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file)
        table.writerows(csv.reader(lines))
        if rows and not lines:
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
        ComparisonError: If the table is of another study, a line of it is not a row, or another
            process is filling it.
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
    with only_writer(path.parent, f".{path.name}.lock"):
        for row in read(path, kind):
            known[row[:length]].append(row)

        missing = [begin for begin in dict.fromkeys(wanted) if begin not in known]
        for first in track(range(0, len(missing), size), label):
            rows = measure(missing[first : first + size])
            write(path, *rows)
            for row in rows:
                known[row[:length]].append(row)
    return [row for begin in wanted for row in known[begin]]
