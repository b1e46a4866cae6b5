"""A shared library that holds an exported policy: opened, checked, called."""

import ctypes
import json
import platform
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aicon_torch.control.elf import read_header
from aicon_torch.errors import OptionError, choices

FORMAT = 1
"""Number of the format of an exported policy: its functions and its metadata."""

_SYMBOLS = ("aicon_sizes", "aicon_metadata", "aicon_blank", "aicon_step", "aicon_test")

_TYPES: dict[str, Any] = {"p": ctypes.c_void_p, "l": ctypes.c_long}
"""Types of arguments: a pointer, a number."""


class Library:
    """An exported policy as functions of arrays.

    The file is native code, which runs with your rights: load none that you would not execute.

    Args:
        path: The file.

    Attributes:
        metadata: What it says of itself.
        dtype: The precision of its numbers.
        readings: How many there are in a robot's readings.
        memory: How many there are in a robot's memory.
        commands: How many there are in a robot's commands.

    Raises:
        OptionError: If it is not one for this machine and this version, or does not compute what it
            did when it was exported.
    """

    def __init__(self, path: str | Path) -> None:
        path = Path(path).resolve()
        if not path.is_file():
            raise OptionError(f"{path} is not there: export a policy to it.")
        library = _open(path)

        sizes = (ctypes.c_int * 5).in_dll(library, "aicon_sizes")
        if sizes[0] != FORMAT:
            raise OptionError(
                f"{path} has format {sizes[0]}, and this version of aicon-torch reads format "
                f"{FORMAT}: export it again."
            )
        self.dtype = np.dtype(np.float32 if sizes[1] == 4 else np.float64)
        self.readings, self.memory, self.commands = sizes[2:]
        self.metadata: dict[str, Any] = json.loads(_text(library, "aicon_metadata"))

        self._blank, self.step = library.aicon_blank, library.aicon_step
        for function, arguments in ((self._blank, "p"), (self.step, "lppppp")):
            function.argtypes = [_TYPES[argument] for argument in arguments]
            function.restype = None
        if not library.aicon_test():
            raise OptionError(
                f"{path} does not compute here what it did when it was exported: export it again "
                "on this machine."
            )

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
        self.step(
            readings.size // self.readings,
            None if starts is None else starts.ctypes.data,
            readings.ctypes.data,
            memory.ctypes.data,
            after.ctypes.data,
            commands.ctypes.data,
        )
        return after, commands


def _open(path: Path) -> ctypes.CDLL:
    """The library, if it is one of ours."""
    header, size = read_header(path), path.stat().st_size
    if header is not None and size < header.size:
        raise OptionError(f"{path} is cut off: {size} of {header.size} bytes. Copy it again.")

    try:
        library = ctypes.CDLL(str(path))
    except OSError as error:
        what = "no library" if header is None else f"a library for {header.machine}"
        raise OptionError(
            f"{path} is {what}; expected a library for this machine ({platform.system()}, "
            f"{platform.machine()}): export the policy here, or its source to a .c file and "
            f"compile it here. {error}."
        ) from error

    missing = [symbol for symbol in _SYMBOLS if not hasattr(library, symbol)]
    if missing:
        raise OptionError(
            f"{path} is a library, but not one that a policy was exported to: it has no "
            f"{choices(missing)}."
        )
    return library


def _text(library: ctypes.CDLL, name: str) -> str:
    """A text that the library holds."""
    symbol = ctypes.c_char.in_dll(library, name)
    return ctypes.string_at(ctypes.addressof(symbol)).decode()
