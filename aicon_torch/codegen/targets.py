"""The machines that a library can be compiled for."""

import platform
import sys

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
