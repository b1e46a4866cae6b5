"""Compiles models of MuJoCo's, in bounded time and memory."""

import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from aicon_torch.errors import OptionError
from aicon_torch.extras import import_extra
from aicon_torch.parts.descriptions import trial
from aicon_torch.parts.descriptions.files import is_text, read_source

MOST_TIME = 5
"""Of the processor, s."""

MOST_MEMORY = 2_000_000_000
"""Bytes."""

LONGEST_WAIT = 60.0
"""For that much of a busy processor, s."""


def compile_mjcf(source: str | Path) -> tuple[Any, Any]:
    """A model, and the specification that it is compiled from.

    A few words of MJCF can stand for any number of bodies, so it is compiled in a process of its
    own first, which ends where it takes too much.

    Args:
        source: A file, or the text of one.

    Returns:
        An ``MjModel`` and an ``MjSpec``.

    Raises:
        FileNotFoundError: If there is no such file.
        OptionError: If MuJoCo does not accept it, or needs too much time or memory.
        ModuleNotFoundError: If MuJoCo is missing.
    """
    mujoco = import_extra("mujoco", "robots")
    name, content = read_source(source)
    if is_text(source):
        _try(name, content)
        spec = mujoco.MjSpec.from_string(content.decode())
    else:
        _try(name, b"", str(Path(source).resolve()))
        spec = mujoco.MjSpec.from_file(str(source))
    return spec.compile(), spec


def _try(name: str, text: bytes, *file: str) -> None:
    """Compile a text or a file in a process of its own.

    Raises:
        OptionError: If it fails, or takes too long or too much memory.
    """
    limits = (str(MOST_TIME), str(MOST_MEMORY))
    command = [sys.executable, "-P", str(trial.__file__), *limits, *file]
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "1"}  # each thread reserves memory

    # A process of its own: what takes too much memory or time ends without ours.
    status, reason = None, ""
    with tempfile.TemporaryDirectory() as folder:  # MuJoCo logs where it is started
        try:
            done = subprocess.run(
                command,
                input=text,
                capture_output=True,
                cwd=folder,
                env=environment,
                timeout=LONGEST_WAIT,
            )
            status, reason = done.returncode, done.stdout.decode(errors="replace")
        except subprocess.TimeoutExpired:
            pass  # it took too long

    # MuJoCo's own words, where it had any.
    if reason:
        raise OptionError(f"MuJoCo does not accept {name}: {reason.strip()[:1000]}")
    if status != 0:
        raise OptionError(
            f"MuJoCo cannot compile {name} within {MOST_TIME} s and {MOST_MEMORY / 1e9:g} GB: "
            "expected a robot, without what stands for very much, such as a <replicate>."
        )
