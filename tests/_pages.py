"""Pages as somebody sees them who opens the file."""

import hashlib
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from playwright.sync_api import Browser, Locator, Page, expect

NAMES = ("navigation", "pusht", "arm", "theory")
TASKS = NAMES[:3]

REST = 500
"""A finger is in the air so long after a drag, ms: what it taps within 100 is taken for no tap."""

PHONE = {"viewport": {"width": 390, "height": 844}, "has_touch": True, "is_mobile": True}
"""A small screen, and a finger."""


@contextmanager
def visited(browser: Browser, path: Path, address: str = "", **looks: Any) -> Iterator[Page]:
    """A page, opened from its file; nothing may go wrong on it or be asked of another place."""
    context = browser.new_context(**looks)
    page = context.new_page()
    page.set_default_timeout(60_000)
    expect.set_options(timeout=60_000)
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
    """Wait for the policy of a task, and let it stand still, long before it has arrived."""
    if not playing:
        page.get_by_role("button", name="Pause").click()
    page.locator("#wants tr").first.wait_for()


def picture(page: Page) -> str:
    """What the first canvas shows, in short."""
    dots: str = page.locator("canvas").first.evaluate("canvas => canvas.toDataURL()")
    return hashlib.sha256(dots.encode()).hexdigest()


def place(page: Page, handle: str) -> tuple[float, float]:
    """Where the middle of something stands that can be taken hold of, px."""
    box = page.locator(f'.handle[data-name="{handle}"]').bounding_box()
    assert box is not None
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


@contextmanager
def changes(look: Callable[[], Any], what: str) -> Iterator[None]:
    """What is done within changes what is seen, soon."""
    before = look()
    yield
    until(lambda: look() != before, f"{what} changes nothing")


def until(is_so: Callable[[], bool], complaint: str) -> None:
    """Wait until something is so."""
    end = time.monotonic() + 60
    while not is_so():
        assert time.monotonic() < end, complaint
        time.sleep(0.05)


class Hand:
    """Does everything by mouse, by finger or by keyboard."""

    def __init__(self, page: Page, way: str) -> None:
        self.page, self.way = page, way
        self.session = page.context.new_cdp_session(page)

    def press(self, control: Locator) -> None:
        """Press a button, or what is checked."""
        if self.way == "mouse":
            control.click()
        elif self.way == "finger":
            control.tap()
        else:
            control.focus()
            self.page.keyboard.press("Space")

    def drag(self, handle: Locator) -> None:
        """Move something that has a circle, to the upper left."""
        handle.scroll_into_view_if_needed()
        if self.way == "keyboard":
            handle.focus()
            self.page.keyboard.press("Shift+ArrowLeft")
            self.page.keyboard.press("ArrowUp")
            return

        box = handle.bounding_box()
        assert box is not None
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        if self.way == "mouse":
            self.page.mouse.move(x, y)
            self.page.mouse.down()
            self.page.mouse.move(x - 15, y - 5, steps=3)
            self.page.mouse.up()
            return

        for kind, left in (("touchStart", 0), ("touchMove", 8), ("touchMove", 16)):
            self.touch(kind, x - left, y - left / 2)
        self.session.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
        self.page.wait_for_timeout(REST)

    def touch(self, kind: str, x: float, y: float) -> None:
        """Put a finger to a place, or move it there."""
        words = {"type": kind, "touchPoints": [{"x": x, "y": y}]}
        self.session.send("Input.dispatchTouchEvent", words)

    def slide(self, slider: Locator) -> None:
        """Move a slider, to near its end."""
        slider.scroll_into_view_if_needed()
        box = slider.bounding_box()
        assert box is not None
        near_end = {"x": 0.8 * box["width"], "y": box["height"] / 2}
        if self.way == "mouse":
            slider.click(position=near_end)
        elif self.way == "finger":
            slider.tap(position=near_end)
        else:
            slider.focus()
            self.page.keyboard.press("ArrowRight")

    def choose(self, choice: Locator, value: str) -> None:
        """Choose of a list, which the browser shows, not the page: only keys are the page's."""
        if self.way != "keyboard":
            choice.select_option(value)
            return
        choice.focus()
        for _ in range(5):
            self.page.keyboard.press("ArrowDown")

    def write(self, field: Locator, words: str) -> None:
        """Write into a field; a finger has the keys of the phone."""
        self.press(field) if self.way != "keyboard" else field.focus()
        self.page.keyboard.press("ControlOrMeta+a")
        self.page.keyboard.type(words)
        self.page.keyboard.press("Enter")
