"""The folder of a comparison, `config.json` and `episodes.csv`: it may be killed at any moment."""

import shutil
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from uuid import uuid4

from aicon_baselines.evaluation.config import Config
from aicon_baselines.evaluation.row import Row, key
from aicon_baselines.evaluation.rows_file import (
    append_rows,
    drop_torn_line,
    read_rows,
    read_whole_rows,
    write_rows,
)
from aicon_baselines.files import only_writer


class RunFolder:
    """The rows of one comparison; `open` gives one, and lets no other process in meanwhile.

    Rows are appended chunk by chunk as they come and sorted at the end of a run, so the file is the
    same however the work was spread, interrupted or divided among interpreters. While chunks are
    running there is a folder with a file for each of them, to which its worker appends a row as an
    episode ends. A later run collects what a killed one has left there.

    Attributes:
        path: The folder.
        config: The comparison.
    """

    def __init__(self, path: Path, config: Config) -> None:
        """Remember where the rows are and what they are of."""
        self.path = path
        self.config = config
        self._rows_path = path / "episodes.csv"
        self._unfinished = path / "unfinished"

    @classmethod
    @contextmanager
    def open(cls, path: Path, config: Config) -> Iterator["RunFolder"]:
        """Open or create the folder, as its only writer while the context lasts.

        Args:
            path: The folder.
            config: The comparison.

        Raises:
            ComparisonError: If the folder holds another comparison, another process writes into it,
                or a file cannot be read or written.
        """
        with only_writer(path):
            config.save(path / "config.json")
            folder = cls(path, config)
            folder._recover()
            yield folder

    def rows(self) -> list[Row]:
        """Read all rows, in the order of the file."""
        return read_rows(self._rows_path)

    def append(self, rows: Iterable[Row]) -> None:
        """Add rows and wait until the disk has them."""
        append_rows(self._rows_path, rows)

    def begin_chunk(self) -> Path:
        """Name a file for the rows of a chunk that will run."""
        self._unfinished.mkdir(exist_ok=True)
        return self._unfinished / f"{uuid4().hex}.csv"

    def count_ended(self) -> int:
        """Count the episodes that have ended in the chunks of this run."""
        return sum(path.read_bytes().count(b"\n") for path in self._unfinished.glob("*.csv"))

    def finish(self) -> None:
        """Put the rows in the order of (policy, condition, repeat, seed); all chunks have ended."""
        write_rows(self._rows_path, sorted(self.rows(), key=key))
        shutil.rmtree(self._unfinished, ignore_errors=True)

    def _recover(self) -> None:
        """Bring in what a killed run has left."""
        drop_torn_line(self._rows_path)
        for leftover in self.path.glob(".new-*"):
            leftover.unlink()

        rows = {key(row) for row in self.rows()}
        left: dict[object, Row] = {}
        for path in sorted(self._unfinished.glob("*.csv")):
            left |= {key(row): row for row in read_whole_rows(path)}
        self.append(row for name, row in left.items() if name not in rows)
        shutil.rmtree(self._unfinished, ignore_errors=True)


def keep(path: Path, rows: Sequence[Row]) -> None:
    """Append rows to the file of a running chunk, where this machine sees its folder."""
    if path.parent.is_dir():
        append_rows(path, rows)
