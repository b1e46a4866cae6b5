"""Files that are no whole exported policy for this machine, and what is to be said of each."""

from pathlib import Path

from aicon_torch.codegen import compile_library

REFUSED = {
    "missing": "missing.so",
    "text": "no shared library|no library",
    "foreign": "no (')?aicon_sizes",
    "other_machine": "for aarch64|cannot open|e_machine|ELF",
    "cut_off": r"is cut off: \d+ of \d+ bytes",
    "other_format": "format 9.* reads format 1",
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
        path.write_bytes(library[:18] + bytes([183, 0]) + library[20:])
    elif name == "cut_off":
        path.write_bytes(library[: len(library) // 2])
    elif name == "other_format":
        text = source.read_text().replace("#define FORMAT 1", "#define FORMAT 9")
        compile_library(text, path)
    elif name == "other_numbers":
        before = "recorded[MEMORY + COMMANDS] = {"
        compile_library(source.read_text().replace(before, before + "1e3 + "), path)
    return path
