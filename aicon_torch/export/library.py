"""A shared library that holds an exported policy: looked at, opened, called."""

import ctypes
import json
import os
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aicon_torch.errors import OptionError, choices
from aicon_torch.export.codegen.seal import read_seal
from aicon_torch.export.codegen.targets import this_machine
from aicon_torch.export.elf import read_header
from aicon_torch.export.loading import open_library

FORMAT = 2
"""Number of the format of an exported policy: its functions and its metadata."""

_SYMBOLS = ("aicon_sizes", "aicon_metadata", "aicon_blank", "aicon_step", "aicon_test")


class Library:
    """An exported policy as functions of arrays.

    It is native code, which runs with your rights: load none that you would not execute. It is
    loaded out of memory, and stays what it is, whatever becomes of the file that it was read from.

    Args:
        content: What is in its file; see also :meth:`read`.
        name: What errors call it.

    Attributes:
        metadata: What it says of itself.
        dtype: The precision of its numbers.
        readings: How many there are in a robot's readings.
        memory: How many there are in a robot's memory.
        commands: How many there are in a robot's commands.

    Raises:
        OptionError: If it is damaged, or is not one for this machine and this version, or does not
            compute what it did when it was exported.
    """

    def __init__(self, content: bytes, name: str) -> None:
        self._content, self._name = content, name
        check_content(content, name)
        library = _open(content, name)

        # Format, bytes of a real number, and how many are in readings, memory and commands.
        sizes = (ctypes.c_int * 5).in_dll(library, "aicon_sizes")
        if sizes[0] != FORMAT:
            raise OptionError(
                f"{name} has format {sizes[0]}, and this version of aicon-torch reads format "
                f"{FORMAT}: export it again."
            )
        self.dtype = np.dtype(np.float32 if sizes[1] == 4 else np.float64)
        self.readings, self.memory, self.commands = sizes[2:]
        self.metadata: dict[str, Any] = json.loads(_metadata(library))

        # They keep the library loaded.
        self._blank, self.step = library["aicon_blank"], library["aicon_step"]
        self._blank.argtypes = [ctypes.c_void_p]
        self.step.argtypes = [ctypes.c_long, *[ctypes.c_void_p] * 5]
        self._blank.restype = self.step.restype = None
        if not library["aicon_test"]():
            raise OptionError(
                f"{name} does not compute here what it did when it was made: export it again on "
                "this machine. If it was made here, something in its graph hangs on rounding."
            )

    @classmethod
    def read(cls, path: str | Path) -> "Library":
        """The library in a file, of which nothing is kept open.

        Args:
            path: The file.
        """
        if not isinstance(path, str | os.PathLike):
            raise OptionError(f"path={path!r}: expected a file, such as 'policy.so'.")
        path = Path(path).resolve()
        if not path.is_file():
            raise OptionError(f"{path} is not there: export a policy to it.")
        return cls(path.read_bytes(), str(path))

    def __reduce__(self) -> tuple[Any, ...]:
        """It is pickled as what is in its file."""
        return Library, (self._content, self._name)

    def __deepcopy__(self, memo: dict[int, Any]) -> "Library":
        """It is its own copy: nothing in it ever changes."""
        return self

    def blank(self) -> NDArray[Any]:
        """The memory before the first episode."""
        memory = np.empty(self.memory, dtype=self.dtype)
        self._blank(memory.ctypes.data)
        return memory

    def run(
        self, readings: NDArray[Any], memory: NDArray[Any], starts: NDArray[np.uint8] | None
    ) -> tuple[NDArray[Any], NDArray[Any]]:
        """One step.

        Args:
            readings: ``(*B, readings)``, contiguous, of this precision; so is the memory.
            memory: ``(*B, memory)``.
            starts: Where an episode begins, ``(*B,)``; None for nowhere.

        Returns:
            The memory ``(*B, memory)`` and the commands ``(*B, commands)``.
        """
        batch = readings.shape[:-1]
        after = np.empty((*batch, self.memory), dtype=self.dtype)
        commands = np.empty((*batch, self.commands), dtype=self.dtype)

        # Pointers into arrays of numpy's: the library itself allocates nothing.
        self.step(
            readings.size // self.readings,
            None if starts is None else starts.ctypes.data,
            readings.ctypes.data,
            memory.ctypes.data,
            after.ctypes.data,
            commands.ctypes.data,
        )
        return after, commands


def check_content(content: bytes, name: str) -> None:
    """Check, before anything of a library runs, that it is whole and for this machine.

    Args:
        content: What is in its file.
        name: What errors call it.

    Raises:
        OptionError: If it is not.
    """
    header, here = read_header(content), this_machine()
    if header is not None and len(content) < header.size:
        raise OptionError(
            f"{name} is cut off: {len(content)} of {header.size} bytes. Copy it again."
        )

    # One that was compiled from its source elsewhere has no last line.
    seal = read_seal(content, name)
    if seal is not None and seal.target != here:
        raise OptionError(
            f"{name} is a library for {seal.target}, and this machine is {here}: load it there, or "
            "export the policy for this one."
        )


def _open(content: bytes, name: str) -> ctypes.CDLL:
    """The library, if it is one of ours."""
    try:
        library = open_library(content)
    except OSError as error:
        header = read_header(content)
        what = "no library" if header is None else f"a library for {header.machine}"
        raise OptionError(
            f"{name} is {what}; expected a library for this machine ({this_machine()}): export the "
            f"policy here, or its source to a .c file and compile it here. {error}."
        ) from error

    # It opened, but that does not make it a policy, ...
    missing = [symbol for symbol in _SYMBOLS if not hasattr(library, symbol)]
    if missing:
        raise OptionError(
            f"{name} is a library, but not one that a policy was exported to: it has no "
            f"{choices(missing)}."
        )

    # ... nor that it is this one.
    if _metadata(library) not in content:
        raise OptionError(f"{name}: the system has loaded another library in its place.")
    return library


def _metadata(library: ctypes.CDLL) -> bytes:
    """What a library says of itself, in JSON."""
    symbol = ctypes.c_char.in_dll(library, "aicon_metadata")
    return ctypes.string_at(ctypes.addressof(symbol))
