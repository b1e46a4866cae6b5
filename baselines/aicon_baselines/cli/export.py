"""Write a task's policy to a file that runs without torch, in microseconds.

Example: aicon export pusht -o pusht.so --target aarch64-linux

A file that ends in .so is a library for this kind of machine, and needs a C compiler; one that ends
in .c is its source, to be compiled elsewhere. aicon_torch.load_exported runs the library in Python,
examples/cpp in C++.
"""

import argparse
from pathlib import Path
from typing import Any

from aicon_baselines.agents.registry import make
from aicon_baselines.cli.command_line import Command
from aicon_baselines.tasks import load, names
from aicon_torch.export.codegen.targets import TARGETS, this_machine


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the task, the file and the machine."""
    parser.add_argument("task", choices=names())
    parser.add_argument(
        "-o", "--output", type=Path, required=True, metavar="FILE", help="ends in .so or .c"
    )
    parser.add_argument(
        "--target",
        choices=TARGETS,
        metavar="MACHINE",
        help="another kind of machine, listed below (default: one like this)",
    )
    parser.add_argument("--policy", default="aicon", help="aicon list names them (default: aicon)")
    parser.add_argument("--condition", help="default: the task's first")


def run(arguments: argparse.Namespace) -> None:
    """Export, load what was written if it is for this machine, and tell what it is."""
    from aicon_torch.export.library import Library

    task, path, target = arguments.task, arguments.output, arguments.target
    condition = arguments.condition or load(task).conditions[0]
    policy: Any = make(task, arguments.policy, condition)
    policy.export(path, target=target, task=task, policy=arguments.policy, condition=condition)

    size = f"{path}: {path.stat().st_size / 1000:.0f} kB"
    if path.suffix == ".c":
        print(size)
        return
    if target not in (None, this_machine()):
        print(f"{size} for {target}, which is tested where it is loaded")
        return
    library = Library.read(path)
    print(
        f"{size}; {library.readings} readings, {library.commands} commands, a memory of "
        f"{library.memory} numbers ({library.dtype})"
    )


def _described() -> str:
    """What the command does, and the machines that it does it for."""
    lines = [
        f"{__doc__}",
        "MACHINE, for which the compiler is pip install 'aicon-torch[compiler]':",
    ]
    for name, target in TARGETS.items():
        lines.append(f"  {name:<15} {target.suffix:<7} {target.computers}")
    return "\n".join(lines)


COMMAND = Command(_described(), add_arguments, run)
