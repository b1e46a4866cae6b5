"""All that can be done on a page is done by mouse, by finger and by keyboard."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from _pages import NAMES, PHONE, TASKS, Hand, changes, picture, place, start, until, visited
from playwright.sync_api import Locator, Page, expect

pytestmark = pytest.mark.slow

HANDLES = {"navigation": "target", "pusht": "object", "arm": "target"}
BUTTONS = ("Pause", "One step", "Kick", "Start again", "Next seed", "Link to this moment")

every_task = pytest.mark.parametrize("name", TASKS)
every_way = pytest.mark.parametrize("way", ["mouse", "finger", "keyboard"])


@every_task
@every_way
def test_every_control_of_a_task(name: str, way: str, pages: Path, browser: Any) -> None:
    with visited(browser, pages / f"{name}.html", **PHONE if way == "finger" else {}) as page:
        start(page, playing=True)
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")  # nothing is cut
        hand = Hand(page, way)
        buttons = {words: page.get_by_role("button", name=words) for words in BUTTONS}
        seed, speed = page.get_by_label("Seed"), page.get_by_label("Speed")

        # It stands still.
        hand.press(buttons["Pause"])
        expect(page.get_by_role("button", name="Go on")).to_be_visible()

        # Whatever has a circle is moved.
        for handle in page.locator(".handle").all():
            with changes(handle.bounding_box, str(handle.get_attribute("aria-label"))):
                hand.drag(handle)

        # So is what was at rest, perhaps since it had arrived before the pause.
        for words in ("One step", "Kick"):
            with changes(lambda: picture(page), words):
                hand.press(buttons[words])

        # The policy is another one.
        for words in ("Sum", "Steepest path", "Projection"):
            hand.press(page.get_by_label(words))
            expect(page.get_by_label(words)).to_be_checked()
        for words in ("Exploration", "Foresight"):
            hand.press(page.get_by_label(words))
            expect(page.get_by_label(words)).not_to_be_checked()

        # So is the episode.
        hand.choose(speed, "8")
        expect(speed).to_have_value("8")
        hand.press(buttons["Start again"])
        expect(buttons["Pause"]).to_be_visible()
        hand.press(buttons["Next seed"])
        expect(seed).not_to_have_value("7")
        hand.write(seed, "7")
        expect(seed).to_have_value("7")
        hand.press(buttons["Link to this moment"])
        expect(page.get_by_role("status")).to_contain_text("link to this moment")
        assert "seed=7" in page.evaluate("location.hash")


RESTARTS = {"wall": "with exploration", "floor": "projection", "potential": "spread"}
"""What falls on a screen of the theory until it starts again."""


def number(told: Locator) -> float:
    """What is told in metres."""
    return float(told.inner_text().split()[0])


def see_all(page: Page) -> Iterator[Locator]:
    """One screen of the theory after the other: what can be moved is there once it is seen."""
    for screen in page.locator("section.screen").all():
        screen.locator(".stage").first.scroll_into_view_if_needed()
        screen.locator(".handle, input[type=range]").first.wait_for()
        yield screen


@every_way
def test_every_control_of_the_theory(way: str, pages: Path, browser: Any) -> None:
    with visited(browser, pages / "theory.html", **PHONE if way == "finger" else {}) as page:
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
        hand = Hand(page, way)
        for screen in see_all(page):
            for slider in screen.locator("input[type=range]").all():
                shown = screen.locator(f'output[name="{slider.get_attribute("name")}"]')
                with changes(shown.inner_text, "slider"):
                    hand.slide(slider)
            for handle in screen.locator(".handle").all():
                with changes(handle.bounding_box, str(handle.get_attribute("aria-label"))):
                    hand.drag(handle)

        for name, words in RESTARTS.items():
            hand.press(page.locator(f"#{name}").get_by_role("button", name="again"))
            page.locator(f"#{name} .stage").first.scroll_into_view_if_needed()
            told = page.locator(f'#{name} [data-told="{words}"]')
            seen = [number(told)]  # words come a little later, so the highest is the beginning

            def falls(told: Any = told, seen: list[float] = seen) -> bool:
                seen.append(number(told))
                return seen[-1] < max(seen) - 0.3

            until(falls, f"{name}: nothing moves")
            page.wait_for_timeout(2000)  # far enough down, so that a new start is seen
            low = number(told)
            hand.press(page.locator(f"#{name}").get_by_role("button", name="again"))
            until(lambda told=told, least=low + 0.2: number(told) > least, f"{name}: no new start")

        drives = page.get_by_label("It drives")
        hand.press(drives)
        expect(drives).not_to_be_checked()


@every_task
def test_a_link_brings_back_the_moment(name: str, pages: Path, browser: Any) -> None:
    path = pages / f"{name}.html"
    with visited(browser, path) as page:
        start(page)
        page.get_by_label("Sum").check()
        for _ in range(8):
            page.get_by_role("button", name="One step").click()
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
        where = place(page, HANDLES[name])

        ranks = page.locator("#wants tr:first-child td:nth-child(3)")
        assert ranks.inner_text() in "12"
        page.get_by_label("Exploration").uncheck()
        page.get_by_label("Sum").check()
        page.get_by_role("button", name="One step").click()
        expect(ranks).to_have_text("–")

        page.get_by_label("Steepest path").check()
        assert page.get_by_label("Exploration").is_disabled()
        page.get_by_label("Foresight").uncheck()
        page.get_by_label("Projection").check()
        page.get_by_role("button", name="One step").click()
        expect(ranks).not_to_have_text("–")
        assert place(page, HANDLES[name]) == pytest.approx(where, abs=60)


@pytest.mark.parametrize("name", NAMES)
def test_tab_and_a_screen_reader_find_everything(name: str, pages: Path, browser: Any) -> None:
    with visited(browser, pages / f"{name}.html") as page:
        if name == "theory":
            assert list(see_all(page))
        else:
            start(page)

        # Each control, and each picture, has a name and a role.
        session = page.context.new_cdp_session(page)
        nodes = session.send("Accessibility.getFullAXTree")["nodes"]
        roles = []
        for node in nodes:
            properties = {p["name"]: p["value"].get("value") for p in node.get("properties", [])}
            role = node.get("role", {}).get("value")
            if node["ignored"] or role in ("RootWebArea", "option", "MenuListOption"):
                continue
            if properties.get("focusable") or role == "image":
                assert node["name"]["value"].strip(), node
                roles.append(role)
        controls = "a[href], button, input:not(:disabled), select"
        shown = page.locator(controls).count()
        assert len([role for role in roles if role != "image"]) == shown
        assert roles.count("image") == page.locator("canvas").count()

        # Tab reaches each of them, radio buttons as one.
        page.evaluate("document.activeElement.blur()")
        reached = set()
        for _ in range(shown + 5):
            page.keyboard.press("Tab")
            reached.add(
                page.evaluate(
                    f"[...document.querySelectorAll('{controls}')].indexOf(document.activeElement)"
                )
            )
        radios = page.locator("input[type=radio]").count()
        assert len(reached - {-1}) == shown - max(radios - 1, 0)
