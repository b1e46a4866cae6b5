"""The C compiler: from a source to a shared library."""

import hashlib
import os
import platform
import shlex
import shutil
import subprocess
import sys
import tempfile
from functools import cache
from importlib.util import find_spec
from pathlib import Path

import torch

from aicon_torch.errors import OptionError
from aicon_torch.export.codegen.seal import MARK, Seal, sealed
from aicon_torch.export.codegen.targets import find_target, this_machine
from aicon_torch.files import check_folder, write_whole

FLAGS = (
    *("-O2", "-std=gnu11", "-fPIC", "-fvisibility=hidden"),
    *("-ffp-contract=off", "-fno-math-errno", "-fno-trapping-math"),
)
"""Numbers as torch computes them: nothing contracted, nothing reordered."""

INSTRUCTIONS = {
    "AVX2": ("-mavx2",),
    "AVX512": ("-mavx512f", "-mavx512dq", "-mavx512bw", "-mavx512vl"),
}
"""What an Intel or AMD processor may know besides, by the name that torch has for it."""

ZIG = (sys.executable, "-m", "ziglang", "cc", "-fno-slp-vectorize")
"""The C compiler that comes as a package, ``pip install 'aicon-torch[compiler]'``.

Vectorizing what is written out, it (clang 20) crashed on the step of an object of pushT.
"""

NO_COMPILER = "no C compiler (pip install 'aicon-torch[compiler]' or apt install gcc)"
"""What is said where none is found."""

_MARKED = f"""
__attribute__((used, visibility("default"))) const char aicon_mark[] = "{MARK}";
#ifdef _WIN32
int _DllMainCRTStartup(void *module, unsigned long reason, void *reserved) {{
  (void)module, (void)reason, (void)reserved;
  return 1;
}}
#endif
"""
"""What every library holds besides."""


def has_compiler() -> bool:
    """Whether there is a C compiler, so that a policy can be compiled and exported.

    It is the one that the variable CC names; where CC is not set, ``cc``, ``gcc`` or ``clang``;
    where there is none of them, that of the package ``ziglang``, which the extra ``compiler``
    brings.

    Raises:
        OptionError: If CC is set and is no command, as where it is empty.
    """
    return _found() is not None


def compiler_command() -> tuple[str, ...]:
    """The words that call the C compiler: see :func:`has_compiler` for which it is.

    Raises:
        OptionError: If there is none, or the variable CC is no command.
    """
    command = _found()
    if command is not None:
        return command

    # Who has set CC is told about CC, and anybody else how to get a compiler.
    named = os.environ.get("CC")
    if named is not None:
        raise OptionError(
            f"There is no C compiler {named!r}, which the variable CC names: expected a command "
            "such as CC=gcc, or no CC."
        )
    raise OptionError(f"There is {NO_COMPILER}.")


def _found() -> tuple[str, ...] | None:
    """The words that call the C compiler; None where there is none."""
    named = os.environ.get("CC")
    if named is not None:
        words = _words(named)
        return words if shutil.which(words[0]) else None

    for name in ("cc", "gcc", "clang"):
        if shutil.which(name):
            return (name,)
    return ZIG if _has_zig() else None


def _words(named: str) -> tuple[str, ...]:
    """The words of the variable CC, such as ``ccache gcc``."""
    try:
        words = tuple(shlex.split(named))
    except ValueError as error:  # a quotation that does not end
        raise OptionError(f"The variable CC is no command: {named!r} ({error}).") from error
    if not words:
        raise OptionError(
            "The variable CC is empty: expected a C compiler, such as CC=gcc, or no variable CC, "
            "where cc, gcc, clang and ziglang are looked for."
        )
    return words


@cache
def _has_zig() -> bool:
    """Whether the package ``ziglang`` is installed."""
    return find_spec("ziglang") is not None


def compile_library(source: str, path: Path, target: str | None = None) -> None:
    """Compile a source in C to a shared library.

    The library runs on every machine of the same architecture. :func:`has_compiler` tells which
    compiler it is; for a target it is that of the package ``ziglang``, which compiles for any. Its
    last line is a checksum, which is looked at when it is loaded.

    Args:
        source: The source.
        path: Where to write the library.
        target: The machine that it shall run on, a name in
            ``aicon_torch.export.codegen.targets.TARGETS``; by default one like this.

    Raises:
        OptionError: If there is no compiler or no such target, or the compiler fails, or the
            library cannot be written.
    """
    check_folder(path)
    write_whole(path, compiled(source, target))


def compiled(source: str, target: str | None = None, stays_here: bool = False) -> bytes:
    """The library of a source: see :func:`compile_library`.

    Args:
        source: The source.
        target: The machine that it shall run on.
        stays_here: Whether it runs on processors like this one only, and may use all of it. The
            numbers are the same, to the last digit.
    """
    try:
        with tempfile.TemporaryDirectory() as folder:
            library, text = Path(folder, "policy.so"), Path(folder, "policy.c")
            text.write_text(source + _MARKED)

            # What may go elsewhere is for all of an architecture, and no flag names a processor.
            if target is None:
                command = compiler_command()
                flags = (*FLAGS, *(_instructions() if stays_here and command != ZIG else ()))
                _run(folder, *command, *flags, "-shared", "-o", library, text, "-lm")
            else:
                _compile_for(target, folder, text, library)
            content = library.read_bytes()
    except OSError as error:  # no program, no library, or no room in the folder
        raise OptionError(
            f"The step cannot be compiled: {error}. CC names another compiler, and TMPDIR another "
            "folder for what it writes."
        ) from error
    return sealed(content, Seal(target or this_machine(), identity(source, target, stays_here)))


def _instructions() -> tuple[str, ...]:
    """The flags that let gcc or clang compute on several numbers at a time, as torch does here."""
    is_known = platform.machine().lower() in ("x86_64", "amd64")
    return INSTRUCTIONS.get(torch.backends.cpu.get_cpu_capability(), ()) if is_known else ()


def _compile_for(target: str, folder: str, text: Path, library: Path) -> None:
    """Compile a source for another machine."""
    machine = find_target(target)
    command = [*ZIG, "-target", machine.triple]
    if not _has_zig():
        raise OptionError(
            f"Compiling for {target} needs the package ziglang: "
            "pip install 'aicon-torch[compiler]'."
        )

    # In two steps, since without libraries there are no headers of C either.
    machine_code = library.with_suffix(".o")
    _run(folder, *command, *FLAGS, *machine.flags, "-c", "-o", machine_code, text)
    _run(folder, *command, *machine.link_flags, "-o", library, machine_code)


def _run(folder: str, *command: str | Path) -> None:
    """Run the compiler, which may leave things in a folder."""
    words = [str(word) for word in command]
    done = subprocess.run(
        words, capture_output=True, text=True, errors="replace", env=_environment(folder)
    )
    if done.returncode != 0:
        said = done.stderr.strip()[:1000] or f"it ended with {done.returncode}, and said nothing"
        raise OptionError(f"{shlex.join(words)} failed: {said}")


def _environment(folder: str) -> dict[str, str]:
    """The compiler's environment: what zig builds once it keeps in the user's cache, if it can."""
    try:
        cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
        cache.mkdir(parents=True, exist_ok=True)
        is_usable = os.access(cache, os.W_OK)
    except (OSError, RuntimeError):  # RuntimeError: there is no home
        is_usable = False
    return {**os.environ} if is_usable else {**os.environ, "ZIG_GLOBAL_CACHE_DIR": folder}


def identity(source: str, target: str | None = None, stays_here: bool = False) -> str:
    """A hash of a source and how it is compiled, 32 hexadecimal digits."""
    # A newer version of the package with other flags shall not take an old library for its own, nor
    # shall another processor that shares a home. Which compiler it was does not matter.
    flags = (*FLAGS, *(_instructions() if stays_here else ()))
    whole = "\n".join((source, *flags, target or this_machine()))
    return hashlib.sha256(whole.encode()).hexdigest()[:32]
