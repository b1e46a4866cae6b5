"""A process that writes into a run folder.

It stands alone, so that a process that imports it imports no torch.
"""

import signal
from multiprocessing.connection import Connection
from pathlib import Path

from aicon_baselines.evaluation.config import Config
from aicon_baselines.evaluation.run_folder import RunFolder


def hold(path: Path, config: Config, opened: Connection) -> None:
    """Open a run folder, say so, and keep it open until the process is killed."""
    with RunFolder.open(path, config):
        opened.send(True)
        signal.pause()
