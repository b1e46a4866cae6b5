"""Files that are whole or not there at all, and folders that one process at a time writes into."""

import json
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from filelock import FileLock, Timeout

from aicon_baselines.evaluation.errors import ComparisonError

LOCK = ".lock"
"""The file that a writer holds; it stays when the writer has ended, and means nothing then."""


@contextmanager
def only_writer(folder: Path, lock_name: str = LOCK) -> Iterator[None]:
    """Be the one process that writes into a folder, which is made if need be.

    The operating system ends the hold with the process, so a killed writer keeps nobody out.

    Args:
        folder: The folder.
        lock_name: The file in it that is held; by its name it may stand for a part of the folder.

    Raises:
        ComparisonError: If another process writes into it, or it cannot be made.
    """
    with writing(folder):
        folder.mkdir(parents=True, exist_ok=True)
        lock = FileLock(folder / lock_name)
        try:
            lock.acquire(blocking=False)
        except Timeout as error:
            raise ComparisonError(
                f"another process is writing into {folder}: wait until it has ended, or choose "
                "another folder"
            ) from error

    try:
        yield
    finally:
        lock.release()


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Give a place beside a file to write to; what was written then replaces it in one go.

    Whoever reads it, also after a kill or a power cut, finds the old file or the new one.

    Args:
        path: The file; the place has the same ending.

    Raises:
        ComparisonError: If it cannot be written, and why.
    """
    place = path.with_name(f".new-{os.getpid()}-{path.name}")
    try:
        with writing(path):
            yield place
            _wait_for_disk(place)
            place.replace(path)
    finally:
        with suppress(OSError):
            place.unlink()


def write_json(path: Path, content: Any) -> None:
    """Write a file of JSON; see `replacing`."""
    with replacing(path) as place:
        place.write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")


def read_text(path: Path) -> str:
    """Read a file of text.

    Raises:
        ComparisonError: If it cannot be read, and why.
    """
    try:
        return path.read_text(encoding="utf-8")
    except OSError as error:
        raise ComparisonError(f"cannot read {path}: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise ComparisonError(f"cannot read {path}: it is no text ({error})") from error


def read_json(path: Path) -> dict[str, Any]:
    """Read a file of JSON that holds names with values.

    Raises:
        ComparisonError: If it cannot be read or holds something else.
    """
    text = read_text(path)
    try:
        content = json.loads(text)
    except ValueError as error:
        raise ComparisonError(f"{path} holds no JSON ({error})") from error
    except RecursionError as error:
        raise ComparisonError(f"{path} holds no JSON (it is nested too deeply)") from error

    if not isinstance(content, dict):
        raise ComparisonError(f"{path} holds a {type(content).__name__}, no names with values")
    return content


@contextmanager
def writing(path: Path) -> Iterator[None]:
    """Say what could not be written, and why, where the operating system refuses."""
    try:
        yield
    except OSError as error:
        raise ComparisonError(f"cannot write {path}: {error.strerror or error}") from error


def check_same_config(
    folder: Path, content: str, saved: Mapping[str, Any], wanted: Mapping[str, Any]
) -> None:
    """Reject a folder that holds something else than what is wanted.

    Args:
        folder: The folder.
        content: What it holds then, for the error: "another agent".
        saved: The options that its content was made with.
        wanted: The options that have to be the same there; tuples are compared as the lists that
            they are in a file.

    Raises:
        ComparisonError: With all options that differ.
    """
    differences = []
    for name, here in sorted(json.loads(json.dumps(wanted)).items()):
        there = saved.get(name)
        if there != here:
            differences.append(f"{name} is {there} there and {here} here")

    if differences:
        raise ComparisonError(
            f"{folder} holds {content}: {'; '.join(differences)}. Choose another folder."
        )


def _wait_for_disk(path: Path) -> None:
    """Return when the disk has all of a file."""
    with path.open("rb") as file:
        os.fsync(file.fileno())
