"""Libraries that were compiled before, in a folder of the user's."""

import logging
from pathlib import Path

from aicon_torch.errors import OptionError
from aicon_torch.export.codegen.compiler import compiled, identity
from aicon_torch.export.codegen.seal import read_seal
from aicon_torch.user_cache import cache_folder, keep, read_kept

_LOGGER = logging.getLogger(__name__)


def cached_library(source: str) -> bytes:
    """The library of a source, compiled if no process of this user has compiled it before.

    Libraries are kept in the user's cache under a name that follows from the whole source. What is
    there is code that will run: it is taken only if it belongs to this user, nobody else may write
    it, its checksum is right, and it was compiled from this source; else it is compiled again.

    Args:
        source: The source.

    Raises:
        OptionError: As :func:`aicon_torch.export.codegen.compile_library`.
    """
    folder = cache_folder()
    if folder is None:
        return compiled(source, stays_here=True)

    # The name is a hash of source and flags, so that no library there is ever out of date.
    path = folder / f"{identity(source, stays_here=True)}.so"
    library = _kept(path, source)
    if library is None:
        library = compiled(source, stays_here=True)
        keep(path, library)
    return library


def _kept(path: Path, source: str) -> bytes | None:
    """The library in a file; None if it is not there, not ours, or not what it should be."""
    library = read_kept(path)
    if library is None:
        return None

    # The seal says from which source it was compiled.
    try:
        seal = read_seal(library, str(path))
    except OptionError as error:
        _LOGGER.info("%s is compiled again: %s", path, error)
        return None
    if seal is None or seal.source != identity(source, stays_here=True):
        _LOGGER.info("%s is compiled again: it was not compiled from this source.", path)
        return None
    return library
