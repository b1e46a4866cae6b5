"""A page that is opened is small, runs at once, and is smooth on a slow phone."""

import gzip
from pathlib import Path
from typing import Any

import pytest
from _pages import NAMES, TASKS, picture, start, visited

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("name", NAMES)
def test_it_is_less_than_a_megabyte(name: str, pages: Path) -> None:
    assert len(gzip.compress((pages / f"{name}.html").read_bytes())) < 1e6


@pytest.mark.parametrize("name", TASKS)
def test_it_moves_by_itself(name: str, pages: Path, browser: Any) -> None:
    with visited(browser, pages / f"{name}.html") as page:
        start(page, playing=True)
        before = picture(page)
        page.wait_for_timeout(1000)
        assert picture(page) != before


@pytest.mark.parametrize("name", NAMES)
def test_a_frame_leaves_time_on_a_slow_processor(name: str, pages: Path, browser: Any) -> None:
    """At a quarter of the speed, what a page does in a frame fits into a sixtieth of a second.

    Sixty frames a second are drawn by a clock of the test's own, and what counts is the time of the
    page's thread, so that a machine that is busy otherwise does not matter.
    """
    with visited(browser, pages / f"{name}.html") as page:
        if name in TASKS:
            start(page, playing=True)
        session = page.context.new_cdp_session(page)
        session.send("Emulation.setCPUThrottlingRate", {"rate": 4})
        session.send("Performance.enable", {"timeDomain": "threadTicks"})

        for part in page.locator(".stage:not(.plot)").all():
            part.scroll_into_view_if_needed()
            page.wait_for_timeout(500)
            before = busy(session)
            page.evaluate("window.drawFrames(180)")
            assert (busy(session) - before) / 180 < 1 / 60


def busy(session: Any) -> float:
    """For how long the thread of a page has worked, s."""
    metrics = session.send("Performance.getMetrics")["metrics"]
    (found,) = [metric["value"] for metric in metrics if metric["name"] == "TaskDuration"]
    return float(found)
