"""A real browser, without a display."""

from collections.abc import Iterator
from typing import Any

import pytest
from _chromium import launched


@pytest.fixture(scope="package")
def browser() -> Iterator[Any]:
    """Chromium, driven by playwright."""
    yield from launched()
