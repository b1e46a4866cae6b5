"""The last line of a library that was compiled here: what it is, and a checksum over all of it.

    aicon-torch library for x86_64-linux, source 3f…c2, checksum 0badcafe

The checksum is CRC-32 (ISO-HDLC, as in zlib) of everything before it. It finds what happens to a
file by accident; whoever can write the file can also write its last line.
"""

import re
import zlib
from typing import NamedTuple

from aicon_torch.errors import OptionError

MARK = "aicon-torch: this file ends in a line with its checksum"
"""What a library holds that has such a line, so that it is missed where it is gone."""

_LINE = "\naicon-torch library for {target:<16}, source {source:32}, checksum "
_TAIL = re.compile(
    rb"\naicon-torch library for (\S+) *, source ([0-9a-f]{32}), checksum .{9}\Z", re.S
)
_LONGEST = 200

_WEB_ASSEMBLY = b"\0asm"
"""What a module of WebAssembly begins with."""


class Seal(NamedTuple):
    """What the last line says.

    Attributes:
        target: The machine that the library is for, such as ``"aarch64-linux"``.
        source: A hash of what it was compiled from, and how: 32 hexadecimal digits.
    """

    target: str
    source: str


def sealed(library: bytes, seal: Seal) -> bytes:
    """The library with its last line; in a module of WebAssembly it is a section of its own.

    Args:
        library: The library.
        seal: What the line says of it.
    """
    # Loaders ignore what follows the end of a library, but in WebAssembly it must be a section.
    if library.startswith(_WEB_ASSEMBLY):
        library += _section(len(_with_line(b"", seal)))
    return _with_line(library, seal)


def _with_line(content: bytes, seal: Seal) -> bytes:
    """What a file holds, and after it the last line."""
    content += _LINE.format(target=seal.target, source=seal.source).encode()
    return content + b"%08x\n" % zlib.crc32(content)


def _section(length: int) -> bytes:
    """What stands before so many bytes that WebAssembly is to pass over."""
    # A custom section: 0, its length, that of its name, its name; the last line is its content.
    name = b"aicon"
    length += 1 + len(name)
    assert length < 128, "a longer section writes its length in more than one byte"
    return bytes([0, length, len(name)]) + name


def read_seal(library: bytes, name: str) -> Seal | None:
    """What the last line of a library says; None if it was compiled elsewhere, and has none.

    Args:
        library: The library.
        name: What errors call it.

    Raises:
        OptionError: If something of the library or of its last line has changed.
    """
    # Where the last line is missing, the mark in the library tells whether there was one.
    line = _TAIL.search(library, max(len(library) - _LONGEST, 0))
    if line is None:
        if MARK.encode() in library:
            raise OptionError(
                f"{name} is damaged or cut off: its last line, with the checksum, is missing. Copy "
                "or export it again."
            )
        return None

    # Written once more from what it says: whatever then differs has changed.
    seal = Seal(line[1].decode(errors="replace"), line[2].decode())
    if _with_line(library[: line.start()], seal) != library:
        raise OptionError(
            f"{name} is damaged: its checksum is not that of its content. Copy or export it again."
        )
    return seal
