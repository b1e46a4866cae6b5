"""A worker ends with the process that started it."""

import os
import subprocess
import sys
import time

from aicon_baselines.evaluation.parent import end_with

# A child that would go on for ever, and says so once it watches.
CHILD = (
    "import os, time; from aicon_baselines.evaluation.parent import end_with; "
    "end_with(os.getppid()); print(os.getpid(), flush=True); time.sleep(3600)"
)
PARENT = f"import subprocess, sys; subprocess.run([sys.executable, '-c', {CHILD!r}])"


def test_a_child_ends_when_its_parent_is_killed() -> None:
    command = [sys.executable, "-c", PARENT]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as parent:
        assert parent.stdout is not None
        child = int(parent.stdout.readline())
        assert is_running(child)

        # Its end of the pipe closes when it ends.
        parent.kill()
        assert parent.stdout.read() == ""
    while is_running(child):
        time.sleep(0.01)


def test_a_process_does_not_watch_itself() -> None:
    end_with(os.getpid())


def is_running(process: int) -> bool:
    """Whether there is such a process."""
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    return True
