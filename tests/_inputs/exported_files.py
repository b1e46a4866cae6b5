"""Files that are no whole exported policy for this machine, and what is to be said of each."""

from pathlib import Path

from aicon_torch.export.codegen import compile_library
from aicon_torch.export.codegen.seal import MARK, Seal, sealed

REFUSED = {
    "missing": "missing.so",
    "text": "no shared library|no library",
    "foreign": "it has no '?aicon_",
    "other_machine": "for aarch64|cannot open|e_machine|ELF",
    "other_target": "for riscv64-linux",
    "changed": "is damaged: its checksum",
    "no_checksum": "is damaged or cut off",
    "cut_off": r"is cut off: \d+ of \d+ bytes",
    "other_format": "format 9.* reads format 2",
    "other_numbers": "computes something else here|does not compute here what it did",
}
"""What an error says of each file."""


def write_wrong_file(name: str, good: Path, folder: Path) -> Path:
    """Write one of the files above.

    Args:
        name: Which.
        good: A policy that was exported, ``.so``, with its source beside it, ``.c``.
        folder: Where to write it.
    """
    path, library, source = folder / f"{name}.so", good.read_bytes(), good.with_suffix(".c")
    if name == "text":
        path.write_text(100 * "not a library ")
    elif name == "foreign":
        compile_library("int answer(void) { return 42; }", path)
    elif name == "other_machine":
        unmarked = unsealed(library).replace(MARK.encode(), bytes(len(MARK)))
        path.write_bytes(unmarked[:18] + bytes([183, 0]) + unmarked[20:])
    elif name == "other_target":
        path.write_bytes(sealed(unsealed(library), Seal("riscv64-linux", 32 * "0")))
    elif name == "changed":
        middle = len(library) // 2
        path.write_bytes(library[:middle] + bytes([library[middle] ^ 1]) + library[middle + 1 :])
    elif name == "no_checksum":
        path.write_bytes(unsealed(library))
    elif name == "cut_off":
        path.write_bytes(library[: len(library) // 2])
    elif name == "other_format":
        text = source.read_text().replace("#define FORMAT 2", "#define FORMAT 9")
        compile_library(text, path)
    elif name == "other_numbers":
        before = "recorded[MEMORY + COMMANDS] = {"
        compile_library(source.read_text().replace(before, before + "1e3 + "), path)
    return path


def unsealed(library: bytes) -> bytes:
    """A library without its last line."""
    return library[: library.rindex(b"\naicon-torch library for")]
