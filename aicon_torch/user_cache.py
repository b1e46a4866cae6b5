"""A private folder of the user's, for what takes long to make and is the same in every process."""

import logging
import os
import stat
from pathlib import Path

from aicon_torch.errors import OptionError
from aicon_torch.files import write_whole

_LOGGER = logging.getLogger(__name__)

_OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH


def cache_folder() -> Path | None:
    """``aicon_torch`` within the user's cache, ``~/.cache`` or XDG_CACHE_HOME.

    It is for this user alone, since what is kept there runs, or moves a robot. None if there can be
    none.
    """
    try:
        cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
        folder = cache / "aicon_torch"
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)

        status = folder.stat()
        if not _is_own(status):
            _LOGGER.warning(
                "Nothing is kept: %s belongs to another user. XDG_CACHE_HOME names another folder.",
                folder,
            )
            return None

        # It is ours, but others could put their files into it.
        if status.st_mode & _OTHERS_WRITE:
            folder.chmod(0o700)
    except (OSError, RuntimeError) as error:  # RuntimeError: there is no home
        _LOGGER.info("Nothing is kept: %s", error)
        return None
    return folder


def read_kept(path: Path) -> bytes | None:
    """What is in a file; None if it is not there, or may be another user's.

    Args:
        path: A file in the folder.
    """
    try:
        if not path.is_file():
            return None
        with path.open("rb") as file:  # looked at and read through one and the same opened file
            status = os.fstat(file.fileno())
            content = file.read()
    except OSError as error:
        _LOGGER.info("%s is made again: %s", path, error)
        return None

    if not _is_own(status) or status.st_mode & _OTHERS_WRITE:
        _LOGGER.warning("%s may be another user's, and is made again.", path)
        return None
    return content


def keep(path: Path, content: bytes) -> None:
    """Keep something for the next time, where that is possible.

    Args:
        path: A file in the folder.
        content: What shall be in it.
    """
    try:
        write_whole(path, content, mode=0o600)
    except OptionError as error:
        _LOGGER.info("Nothing is kept: %s", error)


def _is_own(status: os.stat_result) -> bool:
    """Whether a file or folder belongs to this user; Windows keeps its caches private itself."""
    return not hasattr(os, "geteuid") or status.st_uid == os.geteuid()
