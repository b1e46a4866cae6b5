"""The folder of a comparison, `config.json` and `episodes.csv`: it may be killed at any moment."""

import csv
import io
import os
from collections.abc import Iterable
from pathlib import Path

from aicon_baselines.evaluation.config import Config
from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.evaluation.row import Row, key

_HEADER = ",".join(Row._fields) + "\n"


class RunFolder:
    """The rows of one comparison, with one writer at a time.

    Rows are appended chunk by chunk as they come and sorted at the end of a run, so the file is the
    same however the work was spread, interrupted or divided among interpreters.

    Attributes:
        path: The folder.
        config: The comparison.
    """

    def __init__(self, path: Path, config: Config) -> None:
        """Open or create the folder.

        Args:
            path: The folder.
            config: The comparison; an error if the folder holds another one.
        """
        path.mkdir(parents=True, exist_ok=True)
        config.save(path / "config.json")

        self.path = path
        self.config = config
        self._rows_path = path / "episodes.csv"
        self._repair()

    def rows(self) -> list[Row]:
        """Read all rows, in the order of the file."""
        return read_rows(self._rows_path)

    def append(self, rows: Iterable[Row]) -> None:
        """Add rows and wait until the disk has them."""
        with self._rows_path.open("a", newline="") as file:
            file.write(_to_text(rows))
            file.flush()
            os.fsync(file.fileno())

    def sort(self) -> None:
        """Put the rows in the order of (policy, condition, repeat, seed)."""
        rows = sorted(self.rows(), key=key)
        self._replace(_HEADER + _to_text(rows))

    def _repair(self) -> None:
        """Write the header of a new file; drop a torn last line, left by a killed writer."""
        text = self._rows_path.read_text() if self._rows_path.exists() else ""
        whole_lines = text[: text.rfind("\n") + 1] or _HEADER

        if whole_lines != text:
            self._replace(whole_lines)

    def _replace(self, text: str) -> None:
        """Exchange the file in one go, so that there is always a whole one."""
        temporary = self._rows_path.with_suffix(".tmp")
        temporary.write_text(text)
        temporary.replace(self._rows_path)


def read_rows(path: Path) -> list[Row]:
    """Read the rows of an `episodes.csv`; an error names the line that is not one."""
    with path.open(newline="") as file:
        header, *lines = csv.reader(file)
    if header != list(Row._fields):
        raise ComparisonError(f"{path} has the columns {header}; expected {list(Row._fields)}")

    # The header is line 1.
    rows = []
    for number, fields in enumerate(lines, start=2):
        try:
            rows.append(Row.from_fields(fields))
        except ValueError as error:
            raise ComparisonError(f"{path}, line {number} is not a row: {fields}") from error
    return rows


def _to_text(rows: Iterable[Row]) -> str:
    buffer = io.StringIO(newline="")
    writer = csv.writer(buffer, lineterminator="\n")
    for row in rows:
        writer.writerow(row.to_fields())
    return buffer.getvalue()
