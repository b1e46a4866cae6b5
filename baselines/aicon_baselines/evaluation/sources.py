"""Which modules of one's own the rows of a folder were made by, and whether these are still so."""

import hashlib
import logging
import sys
from collections.abc import Iterable
from pathlib import Path

from aicon_baselines.evaluation.task import Task
from aicon_baselines.files import read_json, write_json

SOURCES = "sources.json"
"""File in the folder of a comparison: for each module of one's own the SHA-256 of its file."""

_LOGGER = logging.getLogger(__name__)


def note_sources(folder: Path, task: Task, policies: Iterable[str], has_rows: bool) -> None:
    """Remember what rows are made by, and warn where those in the folder were made by other files.

    It is the modules of MODULE:TASK, of the model of such a task, and of MODULE:FUNCTION; what
    these import is not looked at.

    Args:
        folder: The folder of a comparison.
        task: The task.
        policies: Names of the policies.
        has_rows: Whether there are rows in the folder; without any, nothing is held against it.
    """
    now = _sources(task, policies)
    if not now:
        return

    path = folder / SOURCES
    noted = read_json(path) if has_rows and path.exists() else {}
    for module, (file, digest) in now.items():
        if noted.setdefault(module, digest) != digest:
            _LOGGER.warning(
                "%s: rows were made by another %s; give a new --out to run them anew",
                folder,
                file.name,
            )
    write_json(path, noted)


def _sources(task: Task, policies: Iterable[str]) -> dict[str, tuple[Path, str]]:
    """Return the file of each module of one's own, and its digest."""
    modules = [name.partition(":")[0] for name in (task.name, *policies) if ":" in name]
    if ":" in task.name:
        modules.append(task.model)

    sources = {}
    for module in modules:
        file = getattr(sys.modules.get(module), "__file__", None)
        if file is not None and Path(file).is_file():
            digest = hashlib.sha256(Path(file).read_bytes()).hexdigest()
            sources[module] = (Path(file), digest)
    return sources
