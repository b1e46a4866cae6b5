"""A progress bar over episodes that end in other processes."""

from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Event, Thread
from types import TracebackType
from typing import Self

from aicon_baselines.extras import missing_extra

try:
    from tqdm import tqdm
except ModuleNotFoundError as error:
    raise missing_extra(error) from error

_INTERVAL = 0.2  # s between two looks at the file


class ProgressBar:
    """Shows how many episodes have ended, on a terminal only.

    Workers call `report` with the bar's path: the file grows by one byte per episode, so its size
    is the count, and appending needs no lock. Workers on machines that do not see the file are
    counted when their rows arrive.

    Attributes:
        path: The file the workers report to, which exists while the bar is shown.
    """

    def __init__(self, done: int, total: int) -> None:
        """Prepare the bar.

        Args:
            done: Number of episodes that need not be run.
            total: Number of episodes of the comparison.
        """
        self._folder = TemporaryDirectory()
        self.path = Path(self._folder.name, "ended")

        self._done = done
        self._total = total
        self._received = 0

        self._stop = Event()
        self._thread = Thread(target=self._follow, daemon=True)

    def received(self, count: int) -> None:
        """Say that the rows of `count` episodes have arrived."""
        self._received += count

    def __enter__(self) -> Self:
        """Show the bar."""
        self.path.write_bytes(b"")
        self._thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        """Leave the bar as it is now."""
        self._stop.set()
        self._thread.join()
        self._folder.cleanup()

    def _follow(self) -> None:
        """Keep the bar at what was reported until the context ends, and look once more then."""
        with tqdm(total=self._total, initial=self._done, unit="episode", disable=None) as bar:
            stopped = False

            while not stopped:
                stopped = self._stop.wait(_INTERVAL)
                ended = max(self.path.stat().st_size, self._received)
                bar.update(self._done + ended - bar.n)


def report(path: Path, count: int) -> None:
    """Add `count` ended episodes to the bar."""
    if path.exists():
        with path.open("ab") as file:
            file.write(b"." * count)
