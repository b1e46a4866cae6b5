"""Libraries that were compiled before, in a folder of the user's."""

import logging
import os
import stat
from pathlib import Path

from aicon_torch.errors import OptionError
from aicon_torch.export.codegen.compiler import compiled, identity
from aicon_torch.export.codegen.files import write_whole
from aicon_torch.export.codegen.seal import read_seal

_LOGGER = logging.getLogger(__name__)

_OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH


def cached_library(source: str) -> bytes:
    """The library of a source, compiled if no process of this user has compiled it before.

    Libraries are kept in ``aicon_torch`` within the user's cache, ``~/.cache`` or XDG_CACHE_HOME,
    under a name that follows from the whole source. What is there is code that will run: it is
    taken only if it belongs to this user, nobody else may write it, its checksum is right, and it
    was compiled from this source; else it is compiled again.

    Args:
        source: The source.

    Raises:
        OptionError: As :func:`aicon_torch.export.codegen.compile_library`.
    """
    folder = _folder()
    if folder is None:
        return compiled(source, stays_here=True)

    # The name is a hash of source and flags, so that no library there is ever out of date.
    path = folder / f"{identity(source, stays_here=True)}.so"
    library = _kept(path, source)
    if library is None:
        library = compiled(source, stays_here=True)
        _keep(library, path)
    return library


def _folder() -> Path | None:
    """The folder of this user's libraries, private; None if there can be none."""
    try:
        cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
        folder = cache / "aicon_torch"
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)

        status = folder.stat()
        if not _is_own(status):
            _LOGGER.warning(
                "Compiled steps are not kept: %s belongs to another user. XDG_CACHE_HOME names "
                "another folder.",
                folder,
            )
            return None

        # It is ours, but others could put their code into it.
        if status.st_mode & _OTHERS_WRITE:
            folder.chmod(0o700)
    except (OSError, RuntimeError) as error:  # RuntimeError: there is no home
        _LOGGER.info("Compiled steps are not kept: %s", error)
        return None
    return folder


def _kept(path: Path, source: str) -> bytes | None:
    """The library in a file; None if it is not there, not ours, or not what it should be."""
    try:
        if not path.is_file():
            return None
        with path.open("rb") as file:  # looked at and read through one and the same opened file
            status = os.fstat(file.fileno())
            library = file.read()

        if not _is_own(status) or status.st_mode & _OTHERS_WRITE:
            _LOGGER.warning("%s may be another user's, and is compiled again.", path)
            return None
        seal = read_seal(library, str(path))
    except (OSError, OptionError) as error:
        _LOGGER.info("%s is compiled again: %s", path, error)
        return None

    # The seal says from which source it was compiled.
    if seal is None or seal.source != identity(source, stays_here=True):
        _LOGGER.info("%s is compiled again: it was not compiled from this source.", path)
        return None
    return library


def _keep(library: bytes, path: Path) -> None:
    """Keep a library for the next time, where that is possible."""
    try:
        write_whole(path, library, mode=0o600)
    except OptionError as error:
        _LOGGER.info("A compiled step is not kept: %s", error)


def _is_own(status: os.stat_result) -> bool:
    """Whether a file or folder belongs to this user; Windows keeps its caches private itself."""
    return not hasattr(os, "geteuid") or status.st_uid == os.geteuid()
