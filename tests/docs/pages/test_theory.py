"""What the page about theory shows is what theory says."""

import re
from pathlib import Path
from typing import Any

import pytest
from _pages import visited
from playwright.sync_api import Locator, Page, expect

pytestmark = pytest.mark.slow


def screen(page: Page, name: str) -> Locator:
    """A screen, in sight."""
    found = page.locator(f"#{name}")
    found.scroll_into_view_if_needed()
    found.locator(".handle, [data-told]:not(:empty)").first.wait_for()
    return found


def number(text: str) -> float:
    """The first number in some words."""
    found = re.search(r"-?\d+(\.\d+)?", text)
    assert found, text
    return float(found[0])


def resting(page: Page, part: Locator) -> dict[str, float]:
    """The heights of both points once the projected one has come down to the floor, and rests."""
    heights = {"sum": 1.0, "projection": 1.0}
    for _ in range(120):
        before = heights
        page.wait_for_timeout(1000)
        for name in heights:
            told = part.locator(f'[data-told="{name}"]').inner_text()
            heights = {**heights, name: number(told)}
        if heights == before and heights["projection"] < 0.2:
            break
    return heights


def set_slider(part: Locator, name: str, value: float) -> None:
    """Move a slider by its keys, as everything else is told of it."""
    part.locator(f'input[name="{name}"]').fill(str(value))


def test_projection_takes_nothing_from_the_leader(pages: Path, browser: Any) -> None:
    with visited(browser, pages / "theory.html") as page:
        part = screen(page, "nullspace")
        expect(part.locator("td").last).not_to_be_empty()
        rows = {
            name: [
                float(text) for text in part.locator(f'[data-row="{name}"] td').all_inner_texts()
            ]
            for name in ("sum", "projection")
        }
        first = 1.6**2 + 0.3**2  # what the leader wants, along itself
        assert rows["projection"][0] == pytest.approx(first, abs=0.01)
        assert rows["sum"][0] < first

        # Turned until they oppose each other, they are in conflict.
        part.locator('[data-name="want 2"]').focus()
        for _ in range(12):
            page.keyboard.press("ArrowDown")
        leader = part.locator('[data-told="leader"]')
        expect(leader).to_contain_text("a conflict; it explores")


@pytest.mark.parametrize(("count", "sinks"), [(1, False), (4, True), (12, True)])
def test_the_sum_sinks_where_the_pulls_together_are_stronger(
    count: int, sinks: bool, pages: Path, browser: Any
) -> None:
    with visited(browser, pages / "theory.html") as page:
        part = screen(page, "floor")
        set_slider(part, "count", count)
        part.get_by_role("button", name="Lift both again").click()
        heights = resting(page, part)
        assert (heights["sum"] < -0.1) == sinks
        assert heights["projection"] > 0.0


def test_the_sum_holds_with_a_weight_that_grows(pages: Path, browser: Any) -> None:
    with visited(browser, pages / "theory.html") as page:
        part = screen(page, "floor")
        set_slider(part, "slope", 6)
        part.get_by_role("button", name="Lift both again").click()
        assert 0.0 < resting(page, part)["sum"] < 0.2


def test_the_sum_rests_where_both_gradients_are_equal(pages: Path, browser: Any) -> None:
    with visited(browser, pages / "theory.html") as page:
        part = screen(page, "wall")
        there = part.locator('[data-told="with exploration"]').filter(has_text="there")
        there.wait_for(timeout=240_000)
        assert "their sum 0.0" in part.locator('[data-told="sum"]').inner_text()

        end = part.locator('[data-name="end 1"]')
        before = str(end.get_attribute("style"))
        end.focus()
        page.keyboard.press("ArrowRight")
        expect(end).not_to_have_attribute("style", before)


def test_more_gradients_come_nearer_than_one(pages: Path, browser: Any) -> None:
    with visited(browser, pages / "theory.html") as page:
        part = screen(page, "foresight")
        left = {}
        for count in (1, 3, 20):
            set_slider(part, "iterations", count)
            told = part.locator('[data-told="left"]')
            expect(told).to_contain_text(f"After {count} ")
            left[count] = number(told.inner_text().partition(" it is ")[2])
        assert left[20] < left[3] < left[1] and left[20] < 0.2


def test_the_target_is_triangulated(pages: Path, browser: Any) -> None:
    with visited(browser, pages / "theory.html") as page:
        part = screen(page, "potential")
        spread = part.locator('[data-told="spread"]')
        page.wait_for_timeout(500)
        before = number(spread.inner_text())
        for _ in range(120):
            if number(spread.inner_text()) < before:
                break
            page.wait_for_timeout(500)
        assert number(spread.inner_text()) < before
        part.locator('input[name="runs"]').uncheck()
        part.get_by_role("button", name="Start again").click()
