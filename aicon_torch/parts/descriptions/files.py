"""The files and texts that describe robots, of bounded size."""

import os
from pathlib import Path

from aicon_torch.errors import OptionError

LARGEST_DESCRIPTION = 10_000_000
"""Bytes of a description; the largest of example-robot-data has 100 kB."""

LARGEST_MESH = 60_000_000
"""Bytes of a mesh: a million triangles as STL."""


def is_text(source: str | Path) -> bool:
    """Whether a source is XML itself, and not the name of a file."""
    return isinstance(source, str) and source.lstrip().startswith("<")


def read_source(source: str | Path) -> tuple[str, bytes]:
    """What errors call a description, and its content.

    Args:
        source: A file, or the text of one.

    Raises:
        FileNotFoundError: If there is no such file.
        OptionError: If it is neither, a folder, or too large.
    """
    if not isinstance(source, str | Path):
        raise OptionError(f"source={source!r}: expected a file, or the text of one.")

    if is_text(source):
        content = str(source).encode(errors="replace")
        _check_size("The text", len(content), LARGEST_DESCRIPTION)
        return "The text", content
    return str(source), read_file(Path(source), LARGEST_DESCRIPTION)


def read_file(path: Path, largest: int) -> bytes:
    """The content of a file.

    Raises:
        FileNotFoundError: If there is no such file.
        OptionError: If it is a folder, cannot be read, or has more bytes than ``largest``.
    """
    check_file(path, largest)
    try:
        return path.read_bytes()
    except OSError as error:
        raise OptionError(f"{path} cannot be read: {error.strerror}.") from error


def check_file(path: Path, largest: int) -> None:
    """Check that there is a file, and that it is not too large; the errors of `read_file`."""
    if os.path.isdir(path):  # pathlib's own may raise, as for a name that is too long
        raise OptionError(f"{path} is a folder: expected a file.")
    if not os.path.isfile(path):
        raise FileNotFoundError(f"{path} is no file.")
    _check_size(str(path), path.stat().st_size, largest)


def _check_size(name: str, size: int, largest: int) -> None:
    """Check the number of bytes."""
    if size > largest:
        raise OptionError(
            f"{name} has {size / 1e6:.0f} MB: expected at most {largest / 1e6:.0f} MB."
        )
