"""A page that is opened is small, and runs at once."""

import gzip
from pathlib import Path
from typing import Any

import pytest
from _pages import NAMES, TASKS, picture, start, until, visited

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("name", NAMES)
def test_it_is_less_than_a_megabyte(name: str, pages: Path) -> None:
    assert len(gzip.compress((pages / f"{name}.html").read_bytes())) < 1e6


@pytest.mark.parametrize("name", TASKS)
def test_it_moves_by_itself(name: str, pages: Path, browser: Any) -> None:
    with visited(browser, pages / f"{name}.html") as page:
        start(page, playing=True)
        before = picture(page)
        until(lambda: picture(page) != before, "nothing moves")
