"""Kill a comparison at random moments, and start it many times at once: nothing may get lost.

Example: python scripts/kill_comparison.py --kills 200 --starts 20 --out runs/kills

After every kill, each row that was there must still be there, and every worker must end. In the end
all files must equal, byte for byte, those of a run that nobody disturbed. Of the processes that
start at once, one may work; the others must end with exit status 2 and say why. What runs is 2D
navigation with two policies that cost next to nothing, since the files are what is tested. Needs
Linux's /proc.
"""

import argparse
import random
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aicon_baselines.cli.command_line import Command, run_command
from aicon_baselines.evaluation.errors import ComparisonError

FILES = ("config.json", "episodes.csv", "success_curve.png", "summary.json")
REFUSAL = "another process is writing into"

_PATIENCE = 5.0  # s that workers have to end


class TowardTarget:
    """Walks toward the target, and into what is in the way.

    Args:
        speed: Its speed, m/s.
    """

    def __init__(self, speed: float) -> None:
        self._speed = speed

    def predict(
        self,
        observation: dict[str, NDArray[Any]],
        state: Any = None,
        episode_start: NDArray[np.bool_] | None = None,
        deterministic: bool = True,
    ) -> tuple[NDArray[np.floating[Any]], None]:
        """Walk in the direction of the bearing."""
        bearing = observation["bearing"]
        return self._speed * np.concatenate([np.cos(bearing), np.sin(bearing)], axis=-1), None


def fast(condition: str) -> TowardTarget:
    """Build a policy that ends soon, at the target or at an obstacle."""
    return TowardTarget(0.5)


def slow(condition: str) -> TowardTarget:
    """Build a policy that needs ten times as long."""
    return TowardTarget(0.05)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare how often to disturb what."""
    parser.add_argument("--kills", type=int, default=20, help="kills (default: 20)")
    parser.add_argument("--starts", type=int, default=20, help="starts at once (default: 20)")
    parser.add_argument("--episodes", type=int, default=64, help="seeds (default: 64)")
    parser.add_argument("--seed", type=int, default=0, help="seed of the moments (default: 0)")
    parser.add_argument("--out", type=Path, required=True, help="folder of the runs, new")


def run(arguments: argparse.Namespace) -> None:
    """Disturb comparisons and say how they went."""
    if arguments.out.exists():
        raise ComparisonError(f"{arguments.out} is there already: choose another folder")

    undisturbed = arguments.out / "undisturbed"
    started = time.monotonic()
    _finish(_start(arguments, undisturbed))
    duration = time.monotonic() - started
    print(f"undisturbed: {duration:.1f} s, {len(rows_in(undisturbed))} rows", flush=True)

    if arguments.kills:
        print(kill_often(arguments, undisturbed, duration), flush=True)
    if arguments.starts:
        print(start_at_once(arguments, undisturbed))


def kill_often(arguments: argparse.Namespace, undisturbed: Path, duration: float) -> str:
    """Kill runs in one folder until they have been killed so often, then let one end.

    A run that ends before its kill leaves a finished folder; the next one begins in a new folder.
    """
    generator = random.Random(arguments.seed)
    folders = [arguments.out / "killed_0"]
    kept: set[str] = set()
    kills = 0

    while kills < arguments.kills:
        process = _start(arguments, folders[-1])
        try:
            process.wait(generator.uniform(0.0, duration))
        except subprocess.TimeoutExpired:
            _kill(process)
            kills += 1
            kept = _check_kept(kept, folders[-1])
            print(f"kill {kills}: {len(kept)} rows are there", flush=True)
        else:
            _finish(process)
            folders.append(arguments.out / f"killed_{len(folders)}")
            kept = set()

    _finish(_start(arguments, folders[-1]))
    for folder in folders:
        _check_same(undisturbed, folder)
    return f"{kills} kills: {len(folders)} runs, all files as undisturbed, no row lost"


def start_at_once(arguments: argparse.Namespace, undisturbed: Path) -> str:
    """Start runs in the same folder at once; those that come too late must say so."""
    folder = arguments.out / "at_once"
    processes = [_start(arguments, folder) for _ in range(arguments.starts)]

    refused = 0
    for process in processes:
        _, errors = process.communicate()
        if process.returncode == 2 and REFUSAL in errors:
            refused += 1
        elif process.returncode != 0:
            raise ComparisonError(f"exit status {process.returncode}: {errors}")

    _check_same(undisturbed, folder)
    return f"{arguments.starts} starts at once: {refused} refused, all files as undisturbed"


def rows_in(folder: Path) -> set[str]:
    """Return the whole lines of a folder: of the finished file, and of unfinished chunks."""
    lines: set[str] = set()
    for path in (folder / "episodes.csv", *folder.glob("unfinished/*.csv")):
        if path.exists():
            lines.update(path.read_text().split("\n")[:-1])
    return {line for line in lines if not line.startswith("policy,")}


def _start(arguments: argparse.Namespace, folder: Path) -> subprocess.Popen[str]:
    module = Path(__file__)
    policies = [f"{module.stem}:fast", f"{module.stem}:slow"]
    words = ["--task", "nav2d", "--policies", *policies, "--jobs", "2"]
    words += ["--episodes", str(arguments.episodes), "--seed", "60000"]
    words += ["--out", str(folder.resolve())]

    # In this folder, where these policies are found.
    command = [sys.executable, "-m", "aicon_baselines.cli.main", "compare", *words]
    return subprocess.Popen(
        command, cwd=module.parent, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
    )


def _finish(process: subprocess.Popen[str]) -> None:
    """Wait for a run that must end well."""
    _, errors = process.communicate()
    if process.returncode != 0:
        raise ComparisonError(f"exit status {process.returncode}: {errors}")


def _kill(process: subprocess.Popen[str]) -> None:
    """Kill a run, and see that its workers end."""
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
    process.kill()
    process.communicate()

    deadline = time.monotonic() + _PATIENCE
    while any(map(_is_alive, children)):
        if time.monotonic() > deadline:
            raise ComparisonError(f"workers {' '.join(filter(_is_alive, children))} go on")
        time.sleep(0.05)


def _is_alive(process: str) -> bool:
    """Return whether there is such a process that has not ended."""
    try:
        state = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0]
    except (FileNotFoundError, ProcessLookupError):
        return False
    return state != "Z"


def _check_kept(before: set[str], folder: Path) -> set[str]:
    """Check that the rows of before are still there, and return all that are there now."""
    now = rows_in(folder)
    if before - now:
        raise ComparisonError(f"lost: {sorted(before - now)}")
    return now


def _check_same(undisturbed: Path, folder: Path) -> None:
    """Check that all files are the same, byte for byte, and that there are no others."""
    differing: Sequence[str] = [
        name for name in FILES if (undisturbed / name).read_bytes() != (folder / name).read_bytes()
    ]
    there, expected = ({path.name for path in each.iterdir()} for each in (folder, undisturbed))
    if differing or there != expected:
        raise ComparisonError(f"{folder} differs: {', '.join(differing)}; {there ^ expected}")


COMMAND = Command(__doc__, add_arguments, run)

if __name__ == "__main__":
    run_command(COMMAND)
