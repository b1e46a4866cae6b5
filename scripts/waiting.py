"""Measure what a user waits for, each in a process of its own, with empty caches.

Example: python scripts/waiting.py --rounds 3

The clock's seconds, and in brackets the processor's, those of compilers included: the medians of
the rounds. Of a policy it is what lies between `make_policy` and a library of machine code, which
is what its first compiled step waits for.
"""

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median

from tqdm import tqdm

from aicon_baselines.cli.command_line import Command, add_option, at_least, run_command
from aicon_baselines.evaluation.tables import to_markdown
from aicon_baselines.evaluation.timing import processor_seconds
from aicon_envs.reach.robots import find_file

EXPORT = """
import sys, time
from aicon_baselines.evaluation.timing import processor_seconds
from aicon_torch import make_policy
policy = make_policy({arguments})
own, clock = processor_seconds(), time.monotonic()
policy.export(sys.argv[1])
print(time.monotonic() - clock, processor_seconds() - own)
"""
"""A program that exports a policy, and prints how long that took."""

UR5 = ("ur_description/urdf/ur5_robot.urdf", "tool0", "ur_description/srdf/ur5.srdf")
KINOVA = ("kinova_description/robots/kinova.urdf", "j2s6s200_end_effector", None)

Wait = Callable[..., tuple[float, float]]
"""What measures seconds, of the clock and of the processor."""

AICON = (sys.executable, "-m", "aicon_baselines.cli.main")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare how often it is measured."""
    add_option(parser, "--rounds", 3, "how often each is measured", type=at_least(1))


def run(arguments: argparse.Namespace) -> None:
    """Print a table."""
    waits: dict[str, tuple[Wait, tuple[str, ...]]] = {
        "`aicon --help`": (ended, (*AICON, "--help")),
        "`aicon list`": (ended, (*AICON, "list")),
        "`aicon watch reach`, to its address": (first_line, (*AICON, "watch", "reach")),
        "navigation, compiled": (exported, ("'nav2d'",)),
        "pushT, compiled": (exported, ("'pusht'",)),
        "reach by a UR5, compiled": (exported, (reaching(*UR5),)),
        "reach by a Kinova, compiled": (exported, (reaching(*KINOVA),)),
    }
    rows = []
    for name, (wait, words) in tqdm(waits.items(), desc="waiting", disable=None):
        clocks, processors = zip(*(wait(*words) for _ in range(arguments.rounds)), strict=True)
        rows.append([name, f"{median(clocks):.1f} ({median(processors):.1f})"])
    print(to_markdown(["s", "clock (processor)"], rows))


def ended(*command: str) -> tuple[float, float]:
    """Seconds until a command ends."""
    own, clock = processor_seconds(), time.monotonic()
    with tempfile.TemporaryDirectory() as cache:
        subprocess.run(command, check=True, capture_output=True, env=without_cache(cache))
    return time.monotonic() - clock, processor_seconds() - own


def first_line(*command: str) -> tuple[float, float]:
    """Seconds until a command says its first line; it is stopped then."""
    own, clock = processor_seconds(), time.monotonic()
    with (
        tempfile.TemporaryDirectory() as cache,
        subprocess.Popen(
            [*command, "--port", "0"],
            env=without_cache(cache),
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
        ) as process,
    ):
        assert process.stdout is not None
        process.stdout.readline()
        taken = time.monotonic() - clock
        process.kill()
    return taken, processor_seconds() - own


def exported(arguments: str) -> tuple[float, float]:
    """Seconds that the export of a policy takes."""
    with tempfile.TemporaryDirectory() as folder:
        program = EXPORT.format(arguments=arguments)
        command = [sys.executable, "-c", program, str(Path(folder, "policy.so"))]
        environment = without_cache(folder)
        done = subprocess.run(command, check=True, capture_output=True, text=True, env=environment)
    clock, processor = done.stdout.split()
    return float(clock), float(processor)


def reaching(urdf: str, tip: str, srdf: str | None) -> str:
    """The arguments of a policy that reaches poses."""
    told = "None" if srdf is None else repr(str(find_file(srdf)))
    return f"'reach', robot={str(find_file(urdf))!r}, tip={tip!r}, srdf={told}, orientation='full'"


def without_cache(folder: str) -> dict[str, str]:
    """The environment, with an empty cache."""
    return {**os.environ, "XDG_CACHE_HOME": folder, "OMP_NUM_THREADS": "1"}


COMMAND = Command(__doc__, add_arguments, run)

if __name__ == "__main__":
    run_command(COMMAND)
