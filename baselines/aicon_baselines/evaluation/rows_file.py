"""Reading and writing files of rows: a header, and a line for each episode."""

import csv
import io
import os
from collections.abc import Iterable
from pathlib import Path

from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.evaluation.row import Key, Row, key
from aicon_baselines.files import read_text, replacing, writing

_HEADER = ",".join(Row._fields) + "\n"


def read_rows(path: Path) -> list[Row]:
    """Read the rows of an `episodes.csv`, in the order of the file, an episode once.

    Raises:
        ComparisonError: If the file cannot be read, a line is not a row, or two rows of the same
            episode differ; it names the line.
    """
    header, *lines = read_text(path).split("\n")[:-1] or [""]
    if header + "\n" != _HEADER:
        raise ComparisonError(f"{path} has the columns {header!r}; expected {_HEADER.strip()!r}")

    # The header is line 1.
    rows: dict[Key, Row] = {}
    for number, line in enumerate(lines, start=2):
        try:
            row = _from_line(line)
        except ValueError as error:
            raise ComparisonError(
                f"{path}, line {number} is not a row: {line!r}; without this line, its episode "
                "is run again"
            ) from error

        known = rows.setdefault(key(row), row)
        if known.to_fields() != row.to_fields():
            raise ComparisonError(
                f"{path}, line {number} says something else than a line above about the same "
                f"episode ({', '.join(map(str, key(row)))}); without both, it is run again"
            )
    return list(rows.values())


def read_whole_rows(path: Path) -> list[Row]:
    """Read the rows of a file without header that a killed process wrote, up to the last whole one.

    Raises:
        ComparisonError: If the file cannot be read.
    """
    rows = []
    for line in read_text(path).split("\n")[:-1]:
        try:
            rows.append(_from_line(line))
        except ValueError:
            break  # a machine that lost its power may leave anything
    return rows


def write_rows(path: Path, rows: Iterable[Row]) -> None:
    """Write a file of these rows, in one go."""
    with replacing(path) as place:
        place.write_text(_HEADER + _to_lines(rows), encoding="utf-8", newline="")


def append_rows(path: Path, rows: Iterable[Row]) -> None:
    """Add rows to a file and wait until the disk has them.

    Raises:
        ComparisonError: If that cannot be, and why.
    """
    with writing(path), path.open("a", encoding="utf-8", newline="") as file:
        file.write(_to_lines(rows))
        file.flush()
        os.fsync(file.fileno())


def drop_torn_line(path: Path) -> None:
    """Write the header of a new file; drop a last line that is not whole, left by a killed writer.

    Raises:
        ComparisonError: If the file cannot be read or written.
    """
    text = read_text(path) if path.exists() else ""
    whole_lines = text[: text.rfind("\n") + 1] or _HEADER

    if whole_lines != text:
        with replacing(path) as place:
            place.write_text(whole_lines, encoding="utf-8", newline="")


def _to_lines(rows: Iterable[Row]) -> str:
    buffer = io.StringIO(newline="")
    writer = csv.writer(buffer, lineterminator="\n")
    for row in rows:
        writer.writerow(row.to_fields())
    return buffer.getvalue()


def _from_line(line: str) -> Row:
    """Read a row; ValueError if it is not one."""
    try:
        (fields,) = csv.reader([line], strict=True)
    except csv.Error as error:
        raise ValueError(str(error)) from error
    return Row.from_fields(fields)
