"""What the rows of a folder were made by: versions, and modules of one's own."""

import hashlib
import logging
import sys
from collections.abc import Collection, Iterable, Mapping
from pathlib import Path

import torch

import aicon_torch
from aicon_baselines.evaluation.predictor import Factory
from aicon_baselines.evaluation.task import Task
from aicon_baselines.files import read_json, write_json

SOURCES = "sources.json"
"""File in the folder of a comparison: for each module of one's own the SHA-256 of its file."""

VERSIONS = "versions.json"
"""File there: for each policy the versions that made its rows, and whether it was compiled."""

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


def note_versions(
    folder: Path, policies: Mapping[str, Factory], with_rows: Collection[str]
) -> None:
    """Remember what makes rows, and warn of policies of which other versions have made some.

    Args:
        folder: The folder of a comparison.
        policies: What builds each policy that makes rows now, by name.
        with_rows: Names of the policies that have rows in the folder.
    """
    path = folder / VERSIONS
    noted = read_json(path) if with_rows and path.exists() else {}
    mixed = []

    for name, build in policies.items():
        now = {
            "aicon-torch": aicon_torch.__version__,
            "torch": str(torch.__version__),
            "compiled": getattr(build, "is_compiled", None),  # None: it may be anything
        }
        before = noted.get(name, [None]) if name in with_rows else []
        noted[name] = before if now in before else [*before, now]
        if len(noted[name]) > 1:
            mixed.append(name)

    if mixed:
        _LOGGER.warning(
            "%s: rows of %s were made by another version, or compiled otherwise (%s); give a new "
            "--out to run them anew",
            folder,
            ", ".join(mixed),
            VERSIONS,
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
