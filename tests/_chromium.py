"""A real browser, without a display."""

import os
import shutil
from collections.abc import Iterator
from typing import Any

import pytest

_CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
_REQUIRED = os.environ.get("AICON_BROWSER") == "required"
_ARGUMENTS = [
    "--no-sandbox",
    "--disable-dev-shm-usage",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
]


def launched() -> Iterator[Any]:
    """Chromium, driven by playwright; for a fixture."""
    api = pytest.importorskip("playwright.sync_api", reason="the browser is driven by playwright")
    if _CHROMIUM is None and not _REQUIRED:
        pytest.skip("no Chromium (apt install chromium)")

    with api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=_CHROMIUM, args=_ARGUMENTS)
        yield browser
        browser.close()
