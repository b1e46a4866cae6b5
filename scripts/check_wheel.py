"""Check a wheel of aicon-torch that is installed, with the extra [pusht] or with none, in this script's environment.

Example, from any folder but the repository's:
    python -I /path/to/scripts/check_wheel.py /path/to/aicon_torch-0.1.0-py3-none-any.whl
"""

import argparse
import importlib
import importlib.util
import re
import sys
import sysconfig
from collections.abc import Sequence
from importlib.machinery import ModuleSpec
from importlib.metadata import distributions, packages_distributions, requires, version
from pathlib import Path
from types import ModuleType
from zipfile import ZipFile

PACKAGES = ("aicon_baselines", "aicon_envs", "aicon_torch")


class OnlyTorchAndNumpy:
    """An import hook that hides every installed module but the standard library's, torch's, numpy's and aicon_torch."""

    def __init__(self) -> None:
        allowed = _with_requirements({"torch", "numpy"})
        owners = {module: set(map(_normal, names)) for module, names in packages_distributions().items()}
        self._hidden = {module for module, names in owners.items() if names.isdisjoint(allowed)} - {"aicon_torch"}

    def find_spec(
        self, name: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Refuse a hidden module; leave the others to the next finder."""
        if name.partition(".")[0] in self._hidden:
            raise ModuleNotFoundError(f"{name} is hidden: aicon_torch imports torch and numpy only", name=name)
        return None


def main() -> None:
    """Run all checks; the first that fails ends the script with an error."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("wheel", type=Path, help="the wheel that was installed")
    check_content(parser.parse_args().wheel)
    check_library_alone()
    check_packages()
    check_rollout()
    check_pushing()


def check_content(wheel: Path) -> None:
    """The wheel holds the three packages with their type markers, and nothing beside them."""
    files = {Path(name) for name in ZipFile(wheel).namelist()}
    top = sorted({file.parts[0] for file in files if not file.parts[0].endswith(".dist-info")})
    _check(top == sorted(PACKAGES), f"{wheel.name} brings exactly {', '.join(top)}")
    missing = [name for name in PACKAGES if Path(name, "py.typed") not in files]
    _check(not missing, f"without py.typed: {', '.join(missing) or 'none'}")


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
    _check("gymnasium" not in sys.modules, "aicon_torch alone, with torch and numpy only, builds the policies")


def check_packages() -> None:
    """All packages come from the environment's site-packages, not from a folder that happens to be near."""
    site = Path(sysconfig.get_path("purelib"))
    for name in PACKAGES:
        module = importlib.import_module(name)
        place = Path(module.__file__ or "")
        _check(place == site / name / "__init__.py", f"{name} is imported from the environment: {place}")
    declared = importlib.import_module("aicon_torch").__version__
    _check(version("aicon-torch") == declared, f"the version is {declared}")


def check_rollout() -> None:
    """The navigation policy leaves a trap and reaches the target."""
    gym = importlib.import_module("gymnasium")
    policy = importlib.import_module("aicon_torch").make_policy("nav2d")
    env = gym.make("aicon/Nav2D-v0", map="u_trap")
    observation, info = env.reset(seed=0)
    memory, steps, over = None, 0, False
    while not over:
        action, memory = policy.predict(observation, memory)
        observation, _, terminated, truncated, info = env.step(action)
        steps, over = steps + 1, terminated or truncated
    _check(info["is_success"], f"a rollout in {info.get('map', 'u_trap')} reaches the target after {steps} steps")


def check_pushing() -> None:
    """The pushing policy reaches the goal pose where the extra is installed; elsewhere the error names it."""
    gym = importlib.import_module("gymnasium")
    if importlib.util.find_spec("pymunk") is None:
        try:
            gym.make("aicon/PushT-v0")
        except gym.error.DependencyNotInstalled as error:
            _check("aicon-torch[pusht]" in str(error), f"without the extra: {error}")
        else:
            _check(False, "aicon/PushT-v0 needs the extra [pusht]")
        return
    policy, env = importlib.import_module("aicon_torch").make_policy("pusht"), gym.make("aicon/PushT-v0")
    observation, info = env.reset(seed=0)
    memory, steps, over = None, 0, False
    while not over:
        action, memory = policy.predict(observation, memory)
        observation, _, terminated, truncated, info = env.step(action)
        steps, over = steps + 1, terminated or truncated
    _check(info["is_success"], f"a rollout in pushT reaches the goal pose after {steps} steps")


def _with_requirements(names: set[str]) -> set[str]:
    """These distributions and all installed ones that they require without extras."""
    installed = {_normal(distribution.metadata["Name"]) for distribution in distributions()}
    found: set[str] = set()
    waiting = set(names)
    while waiting:
        name = waiting.pop()
        found.add(name)
        needed = {_normal(re.split(r"[^\w.-]", line)[0]) for line in requires(name) or () if "extra ==" not in line}
        waiting |= (needed & installed) - found
    return found


def _normal(name: str) -> str:
    """The normal form of a distribution's name."""
    return re.sub(r"[-_.]+", "-", name).lower()


def _check(holds: bool, what: str) -> None:
    if not holds:
        sys.exit(f"check_wheel: FAILED: {what}")
    print(f"check_wheel: {what}")


if __name__ == "__main__":
    main()
