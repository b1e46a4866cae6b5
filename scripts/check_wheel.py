"""Check a wheel of aicon-torch that is installed, with or without extras, in this environment.

Example, from any folder but the repository's:
    python -I /path/to/scripts/check_wheel.py /path/to/aicon_torch-0.1.0-py3-none-any.whl

What has been checked is printed; the first check that fails ends the script. With the extras
[pusht,compare] it also runs a small comparison with the command `aicon`. It parses its arguments by
itself, since it cannot build on what it checks.
"""

import argparse
import importlib
import importlib.util
import re
import subprocess
import sys
import sysconfig
import tempfile
from collections.abc import Sequence
from importlib.machinery import ModuleSpec
from importlib.metadata import distributions, packages_distributions, requires, version
from pathlib import Path
from types import ModuleType
from typing import Any
from zipfile import ZipFile

PACKAGES = ("aicon_baselines", "aicon_envs", "aicon_torch")


class OnlyTorchAndNumpy:
    """An import hook that hides every installed module but torch, numpy, theirs and aicon_torch."""

    def __init__(self) -> None:
        """Find out which top-level modules are to be hidden."""
        allowed = _with_requirements({"torch", "numpy"})
        self._hidden: set[str] = set()

        for module, owners in packages_distributions().items():
            if allowed.isdisjoint(map(_normal_form, owners)) and module != "aicon_torch":
                self._hidden.add(module)

    def find_spec(
        self, name: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Refuse a hidden module; leave the others to the next finder."""
        if name.partition(".")[0] in self._hidden:
            raise ModuleNotFoundError(
                f"{name} is hidden: aicon_torch imports torch and numpy only", name=name
            )
        return None


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
    """``aicon_torch`` and its policies need torch and numpy only."""
    hook = OnlyTorchAndNumpy()
    sys.meta_path.insert(0, hook)
    try:
        library = importlib.import_module("aicon_torch")
        library.make_policy("nav2d")
        library.make_policy("pusht")
    finally:
        sys.meta_path.remove(hook)

    _check(
        "gymnasium" not in sys.modules,
        "aicon_torch alone, with torch and numpy only, builds the policies",
    )


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
    if _has("pymunk"):
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
    """``aicon list`` works, ``aicon compare`` where its extra is installed; else it is named."""
    listed = _run_aicon("list")
    _check("task nav2d" in listed.stdout, f"aicon list names the tasks{listed.stderr}")

    with tempfile.TemporaryDirectory() as folder:
        words = ["--task", "pusht", "--policies", "aicon", "--episodes", "2", "--out", folder]
        compared = _run_aicon("compare", *words)

    if _has("pymunk") and _has("joblib"):
        _check("| aicon | 2/2" in compared.stdout, f"aicon compare compares{compared.stderr}")
    else:
        sentence = compared.stderr.strip().splitlines()[-1]
        _check("pip install 'aicon-torch[" in sentence, f"without extras, {sentence}")


def _roll_out(task: str, environment: str, **options: Any) -> tuple[int, bool]:
    """Run an episode with seed 0; return its steps, and whether it succeeded."""
    policy = importlib.import_module("aicon_torch").make_policy(task)
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


def _has(module: str) -> bool:
    return importlib.util.find_spec(module) is not None


def _with_requirements(names: set[str]) -> set[str]:
    """Return these distributions and all installed ones that they require without extras."""
    installed = {_normal_form(distribution.metadata["Name"]) for distribution in distributions()}
    found: set[str] = set()
    waiting = set(names)

    while waiting:
        name = waiting.pop()
        found.add(name)
        for line in requires(name) or ():
            required = _normal_form(re.split(r"[^\w.-]", line)[0])
            if "extra ==" not in line and required in installed - found:
                waiting.add(required)
    return found


def _normal_form(name: str) -> str:
    """Return the normal form of a distribution's name."""
    return re.sub(r"[-_.]+", "-", name).lower()


def _check(holds: bool, what: str) -> None:
    """Print what has been checked, or end the script."""
    if not holds:
        sys.exit(f"check_wheel: FAILED: {what}")
    print(f"check_wheel: {what}")


if __name__ == "__main__":
    main()
