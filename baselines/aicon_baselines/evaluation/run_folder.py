"""The folder of a comparison, `config.json` and `episodes.csv`: it may be killed at any moment."""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from aicon_baselines.evaluation.config import Config
from aicon_baselines.evaluation.row import Row, key
from aicon_baselines.evaluation.rows_file import (
    append_rows,
    drop_torn_line,
    read_rows,
    write_rows,
)
from aicon_baselines.evaluation.unfinished import UnfinishedChunks
from aicon_baselines.files import only_writer


class RunFolder:
    """The rows of one comparison; `open` gives one, and lets no other process in meanwhile.

    Rows are appended chunk by chunk as they come and sorted at the end of a run, so the file is the
    same however the work was spread, interrupted or divided among interpreters.

    Attributes:
        path: The folder.
        config: The comparison.
        unfinished: What has ended of the chunks that are running.
    """

    def __init__(self, path: Path, config: Config) -> None:
        """Remember where the rows are and what they are of."""
        self.path = path
        self.config = config
        self.unfinished = UnfinishedChunks(path / "unfinished")
        self._rows_path = path / "episodes.csv"

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

    def sort(self) -> None:
        """Put the rows in the order of (policy, condition, repeat, seed)."""
        write_rows(self._rows_path, sorted(self.rows(), key=key))

    def _recover(self) -> None:
        """Bring in what a killed run has left."""
        drop_torn_line(self._rows_path)
        for leftover in self.path.glob(".new-*"):
            leftover.unlink()

        rows = {key(row): row for row in self.rows()}
        left = {key(row): row for row in self.unfinished.left()}
        self.append(row for name, row in left.items() if name not in rows)
        self.unfinished.close()
