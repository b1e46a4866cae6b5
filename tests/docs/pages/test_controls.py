"""All that can be done to a task is done by mouse, by finger and by keyboard."""

from pathlib import Path
from typing import Any

import pytest
from _pages import TASKS, picture, place, start, visited
from playwright.sync_api import Page

pytestmark = pytest.mark.slow

HANDLES = {
    "navigation": ["target", "wall 1"],
    "pusht": ["object", "goal", "turn object", "turn goal"],
    "arm": ["target", "ball"],
}
PHONE = {"viewport": {"width": 390, "height": 844}, "has_touch": True, "is_mobile": True}

every_task = pytest.mark.parametrize("name", TASKS)


@every_task
def test_buttons_do_what_they_say(name: str, pages: Path, browser: Any) -> None:
    with visited(browser, pages / f"{name}.html") as page:
        start(page)
        standing = picture(page)
        page.wait_for_timeout(300)
        assert picture(page) == standing  # paused

        for button in ("One step", "Kick"):
            before = picture(page)
            page.get_by_role("button", name=button).click()
            assert picture(page) != before, button

        page.get_by_role("button", name="Go on").click()
        page.get_by_role("button", name="Pause").wait_for()
        page.get_by_label("Speed").select_option("8")
        page.wait_for_timeout(300)

        page.get_by_role("button", name="Next seed").click()
        seed = int(page.get_by_label("Seed").input_value())
        page.get_by_label("Seed").fill("7")
        page.get_by_label("Seed").press("Enter")
        page.get_by_role("button", name="Start again").click()
        assert seed != 7 and page.get_by_label("Seed").input_value() == "7"


@every_task
def test_a_link_brings_back_the_moment(name: str, pages: Path, browser: Any) -> None:
    path = pages / f"{name}.html"
    with visited(browser, path) as page:
        start(page, playing=True)
        page.get_by_label("Sum").check()
        page.wait_for_timeout(700)
        page.get_by_role("button", name="Link to this moment").click()
        then, address = picture(page), page.evaluate("location.hash")
        page.get_by_role("button", name="One step").click()
        after = picture(page)

    with visited(browser, path, address) as page:
        page.locator("#wants tr").first.wait_for()
        assert page.get_by_label("Sum").is_checked()
        assert picture(page) == then
        page.get_by_role("button", name="One step").click()
        assert picture(page) == after


@every_task
def test_the_rule_changes_in_the_middle_of_an_episode(name: str, pages: Path, browser: Any) -> None:
    with visited(browser, pages / f"{name}.html") as page:
        start(page)
        for _ in range(5):
            page.get_by_role("button", name="One step").click()
        where = place(page, HANDLES[name][0])

        ranks = page.locator("#wants tr:first-child td:nth-child(3)")
        assert ranks.inner_text() in "12"
        page.get_by_label("Exploration").uncheck()
        page.get_by_label("Sum").check()
        page.get_by_role("button", name="One step").click()
        page.wait_for_function("document.querySelector('#wants td:nth-child(3)').innerText === '–'")

        page.get_by_label("Steepest path").check()
        assert page.get_by_label("Exploration").is_disabled()
        page.get_by_label("Foresight").uncheck()
        page.get_by_label("Projection").check()
        page.get_by_role("button", name="One step").click()
        page.wait_for_function("document.querySelector('#wants td:nth-child(3)').innerText !== '–'")
        assert place(page, HANDLES[name][0]) == pytest.approx(where, abs=60)


@every_task
def test_a_mouse_drags(name: str, pages: Path, browser: Any) -> None:
    with visited(browser, pages / f"{name}.html") as page:
        start(page)
        for handle in HANDLES[name]:
            x, y = place(page, handle)
            page.mouse.move(x, y)
            page.mouse.down()
            page.mouse.move(x + 15, y + 5, steps=3)
            page.mouse.up()
            assert place(page, handle) != (x, y), handle


@every_task
def test_a_finger_drags(name: str, pages: Path, browser: Any) -> None:
    with visited(browser, pages / f"{name}.html", **PHONE) as page:
        page.locator("#wants tr").first.wait_for()
        page.get_by_role("button", name="Pause").tap()
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")  # nothing is cut

        session = page.context.new_cdp_session(page)
        for handle in HANDLES[name]:
            page.locator(f'[data-name="{handle}"]').scroll_into_view_if_needed()
            x, y = place(page, handle)
            for kind, dx in (("touchStart", 0), ("touchMove", 8), ("touchMove", 16)):
                points = [{"x": x + dx, "y": y + dx / 2}]
                session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
            session.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
            assert place(page, handle) != (x, y), handle


@every_task
def test_a_keyboard_reaches_everything(name: str, pages: Path, browser: Any) -> None:
    with visited(browser, pages / f"{name}.html") as page:
        start(page)
        page.get_by_label("Exploration").focus()
        page.keyboard.press("Space")
        assert not page.get_by_label("Exploration").is_checked()

        page.get_by_label("Projection").focus()
        page.keyboard.press("ArrowDown")
        assert page.get_by_label("Sum").is_checked()

        # One after the other, from the top of the page.
        page.evaluate("document.activeElement.blur()")
        reached = [tab(page) for _ in range(40)]
        wanted = {"pause", "step", "kick", "again", "seed", "next", "speed", "link", "foresight"}
        assert wanted | set(HANDLES[name]) | {"sum"} <= set(reached)

        for handle in HANDLES[name]:
            before = place(page, handle)
            page.locator(f'[data-name="{handle}"]').focus()
            page.keyboard.press("ArrowLeft")
            page.keyboard.press("Shift+ArrowUp")
            assert place(page, handle) != before, handle


def tab(page: Page) -> str:
    """What the next press of Tab reaches."""
    page.keyboard.press("Tab")
    words: str = page.evaluate(
        "(({ dataset, id, value }) => dataset.name || id || value || '')(document.activeElement)"
    )
    return words


@every_task
def test_a_screen_reader_hears_what_happens(name: str, pages: Path, browser: Any) -> None:
    with visited(browser, pages / f"{name}.html") as page:
        start(page)
        assert page.get_by_role("status").inner_text().endswith(("target.", "off."))
        for handle in HANDLES[name]:
            label = page.locator(f'[data-name="{handle}"]').get_attribute("aria-label")
            assert label and "arrow keys" in label
