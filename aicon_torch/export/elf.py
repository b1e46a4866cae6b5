"""What the first bytes of a shared library of Linux (ELF) say of the whole file.

Mapping a file that is cut off ends the process, so it is looked at before.
"""

import struct
from typing import NamedTuple

_MACHINES = {3: "i386", 40: "arm", 62: "x86_64", 183: "aarch64", 243: "riscv"}

_HEADER_SIZE = 64


class Header(NamedTuple):
    """What a file is.

    Attributes:
        machine: The architecture that its code is for.
        size: Bytes of the whole file.
    """

    machine: str
    size: int


def read_header(content: bytes) -> Header | None:
    """The header of a file; None if it is no library of Linux."""
    first = content[:_HEADER_SIZE]
    if len(first) < _HEADER_SIZE or first[:4] != b"\x7fELF":
        return None

    # The table of sections stands at the end of the file.
    # By byte: 4 the width of addresses, 5 the order of bytes, 18 the machine.
    is_64_bit, order = first[4] == 2, "<" if first[5] == 1 else ">"
    (machine,) = struct.unpack_from(f"{order}H", first, 18)
    if is_64_bit:
        (table,) = struct.unpack_from(f"{order}Q", first, 40)
        entry_size, entries = struct.unpack_from(f"{order}HH", first, 58)
    else:
        (table,) = struct.unpack_from(f"{order}I", first, 32)
        entry_size, entries = struct.unpack_from(f"{order}HH", first, 46)
    return Header(_MACHINES.get(machine, f"machine {machine}"), table + entries * entry_size)
