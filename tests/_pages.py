"""Pages as somebody sees them who opens the file."""

import hashlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from playwright.sync_api import Browser, Page

NAMES = ("navigation", "pusht", "arm", "theory")
TASKS = NAMES[:3]


@contextmanager
def visited(browser: Browser, path: Path, address: str = "", **looks: Any) -> Iterator[Page]:
    """A page, opened from its file; nothing may go wrong on it or be asked of another place."""
    context = browser.new_context(**looks)
    page = context.new_page()
    page.set_default_timeout(60_000)
    complaints: list[str] = []
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.on("console", lambda said: complaints.append(said.text))
    page.on("request", lambda asked: None if is_own(asked.url) else complaints.append(asked.url))

    page.goto(path.as_uri() + address)
    yield page
    context.close()
    assert complaints == []


def is_own(url: str) -> bool:
    """Whether an address is the page itself or something that it holds."""
    return url.startswith(("file:", "data:", "blob:"))


def start(page: Page, *, playing: bool = False) -> None:
    """Wait for the policy of a task, and let it stand still."""
    page.locator("#wants tr").first.wait_for()
    if not playing:
        page.get_by_role("button", name="Pause").click()


def picture(page: Page) -> str:
    """What the first canvas shows, in short."""
    dots: str = page.locator("canvas").first.evaluate("canvas => canvas.toDataURL()")
    return hashlib.sha256(dots.encode()).hexdigest()


def place(page: Page, handle: str) -> tuple[float, float]:
    """Where the middle of something stands that can be taken hold of, px."""
    box = page.locator(f'.handle[data-name="{handle}"]').bounding_box()
    assert box is not None
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
