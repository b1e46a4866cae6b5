"""Compiles a model of MuJoCo's in a process of its own, with bounded time and memory: a script.

    python trial.py SECONDS BYTES [FILE]

Without a file the text comes from the standard input. What MuJoCo has against it is printed.
"""

import sys
from importlib import import_module, util


def main(seconds: str, size: str, file: str | None = None) -> int:
    """Compile it.

    Args:
        seconds: The most processor time, s.
        size: The most memory, bytes.
        file: The file; None for the text on the standard input.

    Returns:
        The status: 0 where MuJoCo accepts it, 1 where not.
    """
    if util.find_spec("resource") is not None:  # Windows has none
        resource = import_module("resource")
        resource.setrlimit(resource.RLIMIT_CPU, (int(seconds), int(seconds)))
        resource.setrlimit(resource.RLIMIT_AS, (int(size), int(size)))

    mujoco = import_module("mujoco")
    try:
        if file is None:
            mujoco.MjModel.from_xml_string(sys.stdin.read())
        else:
            mujoco.MjModel.from_xml_path(file)
    except (ValueError, mujoco.FatalError) as error:
        sys.stdout.write(str(error))
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
