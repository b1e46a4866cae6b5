"""Opening a shared library from the bytes of its file, whatever the file is called.

The system's loader takes a library whose name it knows for the one that it has, and maps its file,
whose bytes may change below a running program. So it is given a file that nobody else has: one in
memory, or a private copy.
"""

import ctypes
import os
import tempfile
import weakref
from contextlib import suppress
from pathlib import Path


def open_library(content: bytes) -> ctypes.CDLL:
    """Load a library.

    Args:
        content: What is in its file.

    Raises:
        OSError: If it is no library for this machine; the text is the loader's reason.
    """
    if hasattr(os, "memfd_create"):
        with suppress(OSError):  # what is in memory may not be allowed to run
            return _open_in_memory(content)

    # Windows keeps the file of a library that is loaded.
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        copy = Path(folder, "policy")
        copy.write_bytes(content)
        try:
            return ctypes.CDLL(str(copy))
        except OSError as error:
            raise OSError(str(error).removeprefix(f"{copy}: ")) from error


def _open_in_memory(content: bytes) -> ctypes.CDLL:
    """Load a library from a file in memory, which is there as long as the library."""
    descriptor = os.memfd_create("aicon_policy")
    try:
        with open(descriptor, "wb", closefd=False) as file:
            file.write(content)
        library = ctypes.CDLL(f"/proc/self/fd/{descriptor}")
    except OSError:
        os.close(descriptor)
        raise

    # Its number is its name, and may be another file's only when this one is unloaded.
    unloading = weakref.finalize(library, _unload, library._handle, descriptor)
    unloading.atexit = False  # a thread may still take a step
    return library


def _unload(handle: int, descriptor: int) -> None:
    """Unload a library, and forget its file."""
    close = ctypes.CDLL(None).dlclose
    close.argtypes = [ctypes.c_void_p]
    close(handle)
    os.close(descriptor)
