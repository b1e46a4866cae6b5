"""A progress bar over episodes that end in other processes."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Event, Thread

from aicon_baselines.extras import naming_extra

with naming_extra():
    from tqdm import tqdm

_INTERVAL = 0.5  # s between two looks


@contextmanager
def progress_bar(done: int, total: int, count_ended: Callable[[], int]) -> Iterator[None]:
    """Show how many episodes have ended while the context lasts, on a terminal only.

    Args:
        done: Number of episodes that need not be run.
        total: Number of episodes of the comparison.
        count_ended: Counts those that have ended meanwhile; called in a thread of its own.
    """
    stop = Event()

    def follow() -> None:
        with tqdm(total=total, initial=done, unit="episode", disable=None) as bar:
            stopped = False
            while not stopped:
                stopped = stop.wait(_INTERVAL)  # and looks once more then
                bar.update(done + count_ended() - bar.n)

    thread = Thread(target=follow, daemon=True)
    thread.start()
    try:
        yield
    finally:
        stop.set()
        thread.join()
