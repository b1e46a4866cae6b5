"""A worker ends with the process that started it."""

import os
import subprocess
import sys
from pathlib import Path

from aicon_baselines.evaluation.backends import end_with

# A child that would go on for ever, and says so once it watches.
CHILD = (
    "import os, time; from aicon_baselines.evaluation.backends import end_with; "
    "end_with(os.getppid()); print(os.getpid(), flush=True); time.sleep(3600)"
)
PARENT = f"import subprocess, sys; subprocess.run([sys.executable, '-c', {CHILD!r}])"

# Two workers that have nothing more to do, in a process that goes on.
IDLE = """
import os, time
from joblib import Parallel, delayed
from aicon_baselines.evaluation.backends import joblib_backend

with joblib_backend("loky", jobs=2, scheduler=None):
    with Parallel() as parallel:
        print(*parallel(delayed(os.getpid)() for _ in range(2)), flush=True)
        time.sleep(3600)
"""


def test_a_child_ends_when_its_parent_is_killed() -> None:
    ends_with_its_parent(PARENT)


def test_an_idle_worker_ends_when_its_parent_is_killed() -> None:
    ends_with_its_parent(IDLE)


def test_a_process_does_not_watch_itself() -> None:
    end_with(os.getpid())


def ends_with_its_parent(program: str) -> None:
    """Run a program that prints the numbers of its children, kill it, and see that they end."""
    command = [sys.executable, "-c", program]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as parent:
        try:
            assert parent.stdout is not None
            children = [int(number) for number in parent.stdout.readline().split()]
            assert children and all(map(is_running, children))
        finally:
            parent.kill()

        # The pipe ends when the last child has: each of them holds an end of it.
        printed, _ = parent.communicate(timeout=60)
        assert printed == ""


def is_running(process: int) -> bool:
    """Whether there is such a process that has not ended; what nobody has waited for has."""
    try:
        state = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0]
    except FileNotFoundError:
        return False
    return state != "Z"
