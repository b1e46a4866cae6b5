"""Pages in a real browser, and what can be seen on them."""

import io
import re
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from PIL import Image
from playwright.sync_api import Browser, Page

from aicon_baselines.view import LiveView


@contextmanager
def opened(browser: Browser, address: str) -> Iterator[Page]:
    """A page, small, since nothing but the processor paints it."""
    page = browser.new_page(viewport={"width": 700, "height": 300})
    page.set_default_timeout(120_000)
    page.goto(address)
    yield page
    page.close()


@contextmanager
def watched(browser: Browser, view: LiveView) -> Iterator[Page]:
    """The page of a view that runs while it is looked at."""
    thread = threading.Thread(target=view.run)
    thread.start()
    try:
        with opened(browser, f"http://127.0.0.1:{view.port}") as page:
            page.get_by_role("button", name="Reset").wait_for()
            yield page
    finally:
        view.stop()
        thread.join(timeout=60)
        view.close()
        assert not thread.is_alive(), "the view goes on although it was stopped"


def wait_until(condition: Callable[[], bool]) -> None:
    """Wait for what a click brings about, patiently: the machine may be busy."""
    for _ in range(2400):
        if condition():
            return
        time.sleep(0.05)
    raise AssertionError("it did not happen")


def picture_of(page: Page) -> np.ndarray[Any, Any]:
    """What the canvas shows, (height, width, 3)."""
    picture = Image.open(io.BytesIO(page.locator("canvas").first.screenshot()))
    return np.asarray(picture.convert("RGB"))


def colors_of(page: Page) -> int:
    """Number of colours that the world is painted in."""
    return len(np.unique(picture_of(page).reshape(-1, 3), axis=0))


def weigh(page: Page, goal: str, factor: float) -> None:
    """Type the weight of a goal into the box beside its slider."""
    label = page.locator("label").filter(has_text=re.compile(f"^{goal}$"))
    box = label.locator("xpath=../../..").locator("input:not([type=hidden])").last
    box.fill(f"{factor:g}")
    box.press("Enter")
