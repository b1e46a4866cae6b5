"""The rows of chunks that are still running, so that a kill loses no episode that had ended."""

import shutil
from collections.abc import Iterator, Sequence
from pathlib import Path
from uuid import uuid4

from aicon_baselines.evaluation.row import Row
from aicon_baselines.evaluation.rows_file import append_rows, read_whole_rows


class UnfinishedChunks:
    """A folder with a file for each chunk that is running.

    A worker appends a row as its episode ends, to a file that no other process writes. When the
    rows of the whole chunk have come back, the file has done its duty. A later run collects what a
    killed one has left.

    Args:
        folder: The folder; it is there while something runs. Workers on machines that do not see it
            write nothing.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def open(self) -> None:
        """Make the folder."""
        self._folder.mkdir(exist_ok=True)

    def new_file(self) -> Path:
        """Name a file for one chunk."""
        return self._folder / f"{uuid4().hex}.csv"

    def left(self) -> Iterator[Row]:
        """Read what a killed run has left; lines that it did not complete are left out."""
        for path in sorted(self._folder.glob("*.csv")):
            yield from read_whole_rows(path)

    def close(self) -> None:
        """Remove the folder with all its files."""
        shutil.rmtree(self._folder, ignore_errors=True)


def keep(path: Path, rows: Sequence[Row]) -> None:
    """Append rows to the file of a running chunk, where this machine sees its folder."""
    if path.parent.is_dir():
        append_rows(path, rows)
