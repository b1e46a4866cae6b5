"""The machines that a library can be compiled for."""

import platform
import sys
from typing import NamedTuple

from aicon_torch.errors import OptionError, choices

_ALONE = ("-shared", "-nostdlib", "-s", "-Wl,--gc-sections", "-Wl,-z,defs")
"""A library for another machine needs none that may not be there, not even C's."""

_WEB = ("-Os", "-fno-pic", "-mbulk-memory")
"""For a page: small, where it is, and what copies numbers is an instruction."""

_ALONE_ON_THE_WEB = (
    *("-nostdlib", "-s", "-Wl,--gc-sections", "-Wl,--no-entry", "-Wl,--export-dynamic"),
    *("-Wl,--export=__heap_base", "-Wl,-z,stack-size=1048576"),
)
"""A module that imports nothing, and says from where on its memory is the page's."""


class Target(NamedTuple):
    """A machine that a library can be compiled for, on any other.

    Attributes:
        triple: What ziglang calls it.
        suffix: How the name of a library ends there.
        computers: Which computers these are.
        flags: Of the compiler, besides those of every library.
        link_flags: Of the linker.
    """

    triple: str
    suffix: str
    computers: str
    flags: tuple[str, ...] = ()
    link_flags: tuple[str, ...] = _ALONE


TARGETS = {
    # The numbers name the oldest glibc to run with: 2.17 of 2012, or 2.27, the first with RISC-V.
    "x86_64-linux": Target("x86_64-linux-gnu.2.17", ".so", "PCs and industrial PCs with Linux"),
    "aarch64-linux": Target(
        "aarch64-linux-gnu.2.17", ".so", "Raspberry Pi OS of 64 bits, NVIDIA Jetson"
    ),
    "armv7-linux": Target("arm-linux-gnueabihf.2.17", ".so", "Raspberry Pi OS of 32 bits"),
    "riscv64-linux": Target("riscv64-linux-gnu.2.27", ".so", "RISC-V boards with Linux"),
    "x86_64-macos": Target("x86_64-macos.11.0", ".dylib", "Macs with Intel's processors"),
    "aarch64-macos": Target("aarch64-macos.11.0", ".dylib", "Macs with Apple's processors"),
    "x86_64-windows": Target("x86_64-windows-gnu", ".dll", "PCs with Windows"),
    "wasm32-web": Target(
        "wasm32-wasi", ".wasm", "browsers and Node.js, by WebAssembly", _WEB, _ALONE_ON_THE_WEB
    ),
}
"""The machines by name, processor and system."""

WEB = "wasm32-web"
"""The one of them that is no machine: a page."""

_MACHINES = {"amd64": "x86_64", "arm64": "aarch64", "armv7l": "armv7", "armv8l": "armv7"}
"""Other names of processors, as systems call them."""

_SYSTEMS = {"darwin": "macos"}
"""Other names of systems."""


def this_machine() -> str:
    """The machine that this process runs on, such as ``"x86_64-linux"``."""
    machine, system = platform.machine().lower(), platform.system().lower()
    machine = _MACHINES.get(machine, machine)

    # A process of 32 bits on a system of 64, as of a Raspberry Pi.
    if machine == "aarch64" and sys.maxsize < 2**32:
        machine = "armv7"
    return f"{machine}-{_SYSTEMS.get(system, system)}"


def find_target(name: str) -> Target:
    """The machine of a name.

    Raises:
        OptionError: If there is none of this name.
    """
    if name not in TARGETS:
        raise OptionError(f"There is no target {name!r}. Targets: {choices(TARGETS)}.")
    return TARGETS[name]
