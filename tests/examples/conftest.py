"""Other people's worlds, of examples/worlds."""

import sys
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

WORLDS = Path(__file__).parents[2] / "examples" / "worlds"


@pytest.fixture
def world_of(monkeypatch: pytest.MonkeyPatch) -> Callable[[str], Any]:
    """The module of a world by its name, which imports its neighbours."""
    monkeypatch.setattr(sys, "path", [str(WORLDS), *sys.path])
    return import_module
