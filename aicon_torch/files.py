"""Files that are there as a whole or not at all."""

import os
import uuid
from contextlib import suppress
from pathlib import Path

from aicon_torch.errors import OptionError


def check_folder(path: Path) -> None:
    """Check that there is a folder for a file.

    Raises:
        OptionError: If there is none.
    """
    if not path.parent.is_dir():
        raise OptionError(f"There is no folder {str(path.parent)!r} to write {str(path)!r} to.")


def write_whole(path: Path, content: bytes, mode: int = 0o666) -> None:
    """Write a file beside its place, and move it there: who reads it meanwhile finds the old one.

    Args:
        path: The file.
        content: What shall be in it.
        mode: Its permissions, less those that the process withholds (umask).

    Raises:
        OptionError: If it cannot be written.
    """
    beside = path.with_name(f".{uuid.uuid4().hex}")
    try:
        # O_EXCL: what has this name already is somebody else's.
        descriptor = os.open(beside, os.O_WRONLY | os.O_CREAT | os.O_EXCL, mode)
        with os.fdopen(descriptor, "wb") as file:
            file.write(content)
        beside.replace(path)
    except OSError as error:
        with suppress(OSError):
            beside.unlink()
        raise OptionError(f"{str(path)!r} cannot be written: {error.strerror}.") from error
