"""Time `predict` of this version beside that of another one, in one run.

Example: git archive fb7da76 | tar x -C build/0.1.0
         python scripts/benchmark_versions.py --other build/0.1.0 --tasks nav2d pusht arm_push

Each version runs in a process of its own, with an empty cache, and the processes take turns on the
same recorded observations of one robot: the other version compiled, this one compiled, and exported
and loaded, as shipped and with one gradient a step. Times are those of the processor,
since other programs may run beside; those of first steps, compilers included but not the import of
the library, are given by the clock as well.
"""

import argparse
import json
import os
import pickle
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from aicon_baselines.cli.command_line import Command, run_command

REPOSITORY = Path(__file__).resolve().parents[1]
OPTIONS: dict[str, dict[str, Any]] = {"arm_push": {"sensing": "pose"}}
CONDITIONS = {"arm_push": "true_pose"}
ONE_GRADIENT = {"law.iterations": 1}
RECORDED = 100

WORKER = Path(__file__).with_name("take_steps.py")
"""What takes the steps, in a process of its own, in which another version may be imported."""

Told = dict[str, tuple[float, float]]
"""Seconds of the processor and by the clock, of what is done once."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what is measured."""
    parser.add_argument("--other", type=Path, help="folder with the source of another version")
    parser.add_argument("--tasks", nargs="+", default=["nav2d", "pusht", "arm_push"])
    parser.add_argument("--rounds", type=int, default=300, help="turns (default: 300)")
    parser.add_argument("--steps", type=int, default=100, help="steps of a turn (default: 100)")


def run(arguments: argparse.Namespace) -> None:
    """Measure the tasks and print a table for each."""
    for task in arguments.tasks:
        measure(task, arguments)


def measure(task: str, arguments: argparse.Namespace) -> None:
    """Measure a task and print its table."""
    with ExitStack() as stack, tempfile.TemporaryDirectory() as folder:
        observations = Path(folder, "observations")
        observations.write_bytes(pickle.dumps(recorded(task)))
        workers: dict[str, Worker] = {}
        for name, (tree, what) in versions(task, Path(folder), arguments.other).items():
            what = {**what, "task": task, "file": str(observations)}
            cache = Path(folder, f"cache_{len(workers)}")  # compilers stumble over spaces
            cache.mkdir()
            workers[name] = stack.enter_context(started(tree, what, cache))
            print(f"{task}, {name}: {in_words(workers[name].told)}", flush=True)

        times: dict[str, list[list[float]]] = {name: [] for name in workers}
        for _ in range(arguments.rounds):
            for name, worker in workers.items():
                times[name].append(worker.turn(arguments.steps))
        report(task, times)


def versions(task: str, folder: Path, other: Path | None) -> dict[str, tuple[Path, dict[str, Any]]]:
    """What is measured: from which source, and what is to be built, written or loaded there."""
    options = OPTIONS.get(task, {})
    laws = {"as shipped": options, "one gradient": {**options, **ONE_GRADIENT}}
    files = {law: str(folder / f"{law}.so") for law in laws}

    found: dict[str, tuple[Path, dict[str, Any]]] = {}
    if other is not None:
        found["the other"] = other.resolve(), {"options": options}
    exports = {files[law]: options for law, options in laws.items()}
    found["compiled"] = REPOSITORY, {"options": options, "exports": exports}
    for law, file in files.items():
        found[f"loaded, {law}"] = REPOSITORY, {"load": file}
    return found


def report(task: str, times: dict[str, list[list[float]]]) -> None:
    """Print the times of steps, and their ratios to the other version's, turn by turn."""
    reference = np.median(times["the other"], axis=1) if "the other" in times else None
    for name, turns in times.items():
        median, slow, largest = 1e6 * np.percentile(turns, (50, 99, 100))
        line = f"{median:.1f} us, 99th percentile {slow:.1f}, largest {largest:.0f}"
        if reference is not None and name != "the other":
            ratios = reference / np.median(turns, axis=1)
            low, middle, high = np.percentile(ratios, (5, 50, 95))
            line += f"; {middle:.3g} times as fast ({low:.3g} to {high:.3g})"
        print(f"{task}, {name}: {line}", flush=True)


def in_words(told: Told) -> str:
    """How long each thing took that is done once."""
    parts = []
    for name, (processor, clock) in told.items():
        parts.append(f"{name} {processor:.2f} s ({clock:.2f} by the clock)")
    return ", ".join(parts)


def recorded(task: str) -> list[dict[str, Any]]:
    """Observations of one robot."""
    from aicon_baselines.cli.bench import observations_of_one
    from aicon_baselines.tasks import load

    condition = CONDITIONS.get(task, load(task).conditions[0])
    return observations_of_one(task, condition, RECORDED)


class Worker:
    """A process that takes turns."""

    def __init__(self, process: "subprocess.Popen[str]") -> None:
        self.process = process
        self.told: Told = self._answer()

    def turn(self, steps: int) -> list[float]:
        """Seconds of each of some steps."""
        assert self.process.stdin is not None
        self.process.stdin.write(f"{steps}\n")
        self.process.stdin.flush()
        seconds: list[float] = self._answer()
        return seconds

    def _answer(self) -> Any:
        assert self.process.stdout is not None
        answer = self.process.stdout.readline()
        if not answer:
            raise RuntimeError(f"a worker ended, with exit status {self.process.wait()}")
        return json.loads(answer)


@contextmanager
def started(tree: Path, what: dict[str, Any], cache: Path) -> Iterator[Worker]:
    """A worker that imports the library from a folder and keeps what it compiles in another."""
    environment = dict(os.environ, PYTHONPATH=str(tree), OMP_NUM_THREADS="1")
    for name in ("XDG_CACHE_HOME", "TORCHINDUCTOR_CACHE_DIR", "TMPDIR", "HOME"):
        environment[name] = str(cache)
    command = [sys.executable, "-W", "ignore", str(WORKER), json.dumps(what)]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, env=environment, text=True, stdin=pipe, stdout=pipe) as process:
        yield Worker(process)
        assert process.stdin is not None
        process.stdin.close()


COMMAND = Command(__doc__, add_arguments, run)

if __name__ == "__main__":
    run_command(COMMAND)
