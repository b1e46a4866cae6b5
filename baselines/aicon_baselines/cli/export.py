"""Write a task's policy to a file that runs without torch, in microseconds.

Example: aicon export pusht -o pusht.so --target aarch64-linux

A file that ends in .so is a library for this kind of machine, and needs a C compiler; one that ends
in .wasm is a module for web pages; one that ends in .c is its source, to be compiled elsewhere.
aicon_torch.load_exported runs the library in Python, examples/cpp in C++, examples/web in a page.

MACHINE is one of these; the compiler for it is pip install 'aicon-torch[compiler]'.

  x86_64-linux   .so    PCs and industrial PCs with Linux
  aarch64-linux  .so    Raspberry Pi OS of 64 bits, NVIDIA Jetson
  armv7-linux    .so    Raspberry Pi OS of 32 bits
  riscv64-linux  .so    RISC-V boards with Linux
  x86_64-macos   .dylib Macs with Intel's processors
  aarch64-macos  .dylib Macs with Apple's processors
  x86_64-windows .dll   PCs with Windows
  wasm32-web     .wasm  browsers and Node.js, by WebAssembly
"""

import argparse
import gzip
from pathlib import Path
from typing import Any

from aicon_baselines.agents.registry import make
from aicon_baselines.cli.command_line import Command, add_option
from aicon_baselines.evaluation.config import one_episode
from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.tasks import choices, load


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the task, the file and the machine."""
    parser.add_argument("task", metavar="TASK", help=choices())
    parser.add_argument(
        "-o", "--output", type=Path, required=True, metavar="FILE", help="ends in .so, .wasm or .c"
    )
    parser.add_argument(
        "--target",
        metavar="MACHINE",
        help="another kind of machine, see above (default: one like this)",
    )
    add_option(parser, "--policy", "aicon", "aicon list names them")
    parser.add_argument("--condition", help="default: the task's first")


def run(arguments: argparse.Namespace) -> None:
    """Export, load what was written if it is for this machine, and tell what it is."""
    from aicon_torch import Policy
    from aicon_torch.export.codegen.targets import this_machine
    from aicon_torch.export.library import Library

    task, path, target = arguments.task, arguments.output, arguments.target
    _, condition = one_episode(load(task), arguments.condition, seed=0)
    policy: Any = make(task, arguments.policy, condition)
    if not isinstance(policy, Policy):
        raise ComparisonError(
            f"the policy {arguments.policy!r} cannot be exported; those of the library can, such "
            "as aicon, steepest or potential_field"
        )
    policy.export(path, target=target, task=task, policy=arguments.policy, condition=condition)

    size = f"{path}: {path.stat().st_size / 1000:.0f} kB"
    if path.suffix == ".wasm":
        packed = len(gzip.compress(path.read_bytes()))
        print(f"{size}, {packed / 1000:.0f} kB by gzip, for web pages: examples/web loads it")
        return
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


COMMAND = Command(__doc__, add_arguments, run)
