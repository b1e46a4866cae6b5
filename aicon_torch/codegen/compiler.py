"""The C compiler: from a source to a shared library."""

import hashlib
import logging
import os
import platform
import shlex
import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from aicon_torch.errors import OptionError

_LOGGER = logging.getLogger(__name__)

FLAGS = (
    *("-O2", "-std=gnu11", "-shared", "-fPIC", "-fvisibility=hidden"),
    *("-ffp-contract=off", "-fno-math-errno", "-fno-trapping-math"),
)
"""Numbers as torch computes them: nothing contracted, nothing reordered."""


@contextmanager
def cached_library(source: str) -> Iterator[Path]:
    """The library of a source, compiled if no process of this user has compiled it before.

    Libraries are kept in ``aicon_torch`` within the user's cache, ``~/.cache`` or XDG_CACHE_HOME,
    under a name that follows from the whole source. Where nothing can be kept, the library is there
    until it is loaded.

    Args:
        source: The source.

    Raises:
        OptionError: As :func:`compile_library`.
    """
    identity = "\n".join((source, *FLAGS, platform.machine()))
    name = hashlib.sha256(identity.encode()).hexdigest()[:32]

    kept = _kept(source, name)
    if kept is not None:
        yield kept
        return
    with tempfile.TemporaryDirectory() as folder:
        library = Path(folder, f"{name}.so")
        compile_library(source, library)
        yield library


def _kept(source: str, name: str) -> Path | None:
    """The library in the user's cache; None if nothing can be written there."""
    try:
        cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache", "aicon_torch")
        library = cache / f"{name}.so"
        if not library.is_file():
            cache.mkdir(parents=True, exist_ok=True)
            compile_library(source, library)
    except (OSError, RuntimeError) as error:  # RuntimeError: there is no home
        _LOGGER.info("Compiled steps are not kept: %s", error)
        return None
    return library


def compile_library(source: str, path: Path) -> None:
    """Compile a source in C to a shared library.

    The compiler is that of the variable CC, by default ``cc``. The library runs on every machine of
    the same architecture.

    Args:
        source: The source.
        path: Where to write the library.

    Raises:
        OptionError: If there is no compiler, or it fails.
    """
    compiler = shlex.split(os.environ.get("CC", "cc"))
    if shutil.which(compiler[0]) is None:
        raise OptionError(
            f"There is no C compiler {compiler[0]!r} (Debian: apt install gcc; the variable CC "
            "names another). Export the source instead, to a file that ends in .c."
        )

    # Beside its place, and moved there when it is whole: a library in use must not change.
    with tempfile.TemporaryDirectory(dir=path.parent) as folder:
        library, text = Path(folder, "policy.so"), Path(folder, "policy.c")
        text.write_text(source)
        command = [*compiler, *FLAGS, "-o", str(library), str(text), "-lm"]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode != 0:
            raise OptionError(f"{shlex.join(command)} failed: {done.stderr.strip()[:1000]}")
        library.replace(path)
