"""Check a wheel of aicon-torch that is installed, with or without extras, in this environment.

Example, from any folder but the repository's:
    python -I /path/to/scripts/check_wheel.py /path/to/aicon_torch-0.1.0-py3-none-any.whl

What has been checked is printed; the first check that fails ends the script. It parses its
arguments by itself, since it cannot build on what it checks.
"""

import argparse
import importlib
import importlib.util
import subprocess
import sys
import sysconfig
from importlib.metadata import version
from pathlib import Path
from typing import Any
from zipfile import ZipFile

PACKAGES = ("aicon_baselines", "aicon_envs", "aicon_torch")


def main() -> None:
    """Run all checks."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("wheel", type=Path, help="the wheel that was installed")

    check_content(parser.parse_args().wheel)
    check_library_alone()
    check_packages()
    check_navigation()
    check_pushing()
    check_command()


def check_content(wheel: Path) -> None:
    """The wheel holds the three packages with their type markers, and nothing beside them."""
    files = {Path(name) for name in ZipFile(wheel).namelist()}
    folders = {file.parts[0] for file in files}
    packages = sorted(folder for folder in folders if not folder.endswith(".dist-info"))
    _check(packages == sorted(PACKAGES), f"{wheel.name} brings exactly {', '.join(packages)}")

    untyped = [name for name in PACKAGES if Path(name, "py.typed") not in files]
    _check(not untyped, f"without py.typed: {', '.join(untyped) or 'none'}")


def check_library_alone() -> None:
    """``aicon_torch`` and its policies load none of the other packages, nor what those need."""
    library = importlib.import_module("aicon_torch")
    library.make_policy("nav2d")
    library.make_policy("pusht")
    loaded = sys.modules.keys() & {"gymnasium", "scipy", "aicon_envs", "aicon_baselines"}
    _check(not loaded, f"aicon_torch builds its policies alone; also loaded: {loaded or 'nothing'}")


def check_packages() -> None:
    """All packages come from the environment's site-packages, not from a folder near by."""
    site = Path(sysconfig.get_path("purelib"))
    for name in PACKAGES:
        file = Path(importlib.import_module(name).__file__ or "")
        expected = site / name / "__init__.py"
        _check(file == expected, f"{name} is imported from the environment: {file}")

    declared = importlib.import_module("aicon_torch").__version__
    _check(version("aicon-torch") == declared, f"the version is {declared}")


def check_navigation() -> None:
    """The navigation policy leaves a trap and reaches the target."""
    steps, success = _roll_out("nav2d", "aicon/Nav2D-v0", map="u_trap")
    _check(success, f"a rollout in u_trap reaches the target after {steps} steps")


def check_pushing() -> None:
    """The pushing policy reaches the goal pose with the extra; without it the error names it."""
    if importlib.util.find_spec("pymunk") is not None:
        steps, success = _roll_out("pusht", "aicon/PushT-v0")
        _check(success, f"a rollout in pushT reaches the goal pose after {steps} steps")
        return

    gym = importlib.import_module("gymnasium")
    try:
        gym.make("aicon/PushT-v0")
    except gym.error.DependencyNotInstalled as error:
        _check("aicon-torch[pusht]" in str(error), f"without the extra: {error}")
    else:
        _check(False, "aicon/PushT-v0 needs the extra [pusht]")


def check_command() -> None:
    """``aicon list`` works, and ``aicon compare`` names the extra that it lacks."""
    listed = _run_aicon("list")
    _check("task nav2d" in listed.stdout, f"aicon list names the tasks{listed.stderr}")

    if importlib.util.find_spec("joblib") is None:
        compared = _run_aicon("compare", "--task", "nav2d", "--policies", "aicon", "--out", "none")
        sentence = compared.stderr.strip().splitlines()[-1]
        _check("pip install 'aicon-torch[" in sentence, f"without extras, {sentence}")


def _roll_out(task: str, environment: str, **options: Any) -> tuple[int, bool]:
    """Run a compiled policy with seed 0; return its steps, and whether it succeeded."""
    policy = importlib.import_module("aicon_torch").make_policy(task).compile()
    env = importlib.import_module("gymnasium").make(environment, **options)
    observation, info = env.reset(seed=0)

    memory, steps, ended = None, 0, False
    while not ended:
        action, memory = policy.predict(observation, memory)
        observation, _, terminated, truncated, info = env.step(action)
        steps, ended = steps + 1, terminated or truncated
    return steps, bool(info["is_success"])


def _run_aicon(*words: str) -> subprocess.CompletedProcess[str]:
    """Run the command of this environment."""
    command = Path(sysconfig.get_path("scripts"), "aicon")
    return subprocess.run([command, *words], capture_output=True, text=True, check=False)


def _check(holds: bool, what: str) -> None:
    """Print what has been checked, or end the script."""
    if not holds:
        sys.exit(f"check_wheel: FAILED: {what}")
    print(f"check_wheel: {what}")


if __name__ == "__main__":
    main()
