"""For how long each page works for one frame, on a processor that is slowed down to a quarter.

Frames are drawn by a clock of this program, a sixtieth of a second after each other, and what
counts is the time of the page's own thread. It needs Chromium and playwright.

Example: python docs/web/time_frames.py
"""

import argparse
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from playwright.sync_api import Page, sync_playwright

from aicon_baselines.cli.command_line import Command, run_command
from make_pages import make_pages

FRAMES = 180
"""How many frames are drawn in each part of a page."""

BY_HAND = """
    const request = window.requestAnimationFrame.bind(window), waiting = new Set();
    window.requestAnimationFrame = (draw) => {
        waiting.add(draw);
        return request((now) => { if (waiting.delete(draw)) draw(now); });
    };
    window.drawFrames = (count) => {
        const begin = performance.now();
        for (let i = 1; i <= count; ++i) {
            const now = [...waiting];
            waiting.clear();
            for (const draw of now) draw(begin + (1000 / 60) * i);
        }
    };
"""
"""Lets frames be drawn by hand."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare where the pages are."""
    parser.add_argument("--pages", type=Path, help="folder of the pages (default: they are made)")


def run(arguments: argparse.Namespace) -> None:
    """Print the time of a frame in each part of each page."""
    with tempfile.TemporaryDirectory() as made, sync_playwright() as playwright:
        folder = arguments.pages or Path(made)
        if arguments.pages is None:
            make_pages(folder)

        chromium = shutil.which("chromium") or shutil.which("chromium-browser")
        browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        for path in sorted(folder.glob("*.html")):
            page = browser.new_page()
            page.add_init_script(BY_HAND)
            page.goto(path.absolute().as_uri())
            times = ", ".join(f"{1e3 * seconds:.1f}" for seconds in frame_times(page))
            print(f"{path.stem}: {times} ms", flush=True)
            page.close()


def frame_times(page: Page) -> Iterator[float]:
    """The time of a frame, s, in each part of a page that draws."""
    page.locator("canvas").first.wait_for()
    page.wait_for_timeout(3000)  # until the first policy is there
    session = page.context.new_cdp_session(page)
    session.send("Emulation.setCPUThrottlingRate", {"rate": 4})
    session.send("Performance.enable", {"timeDomain": "threadTicks"})

    for part in page.locator(".stage:not(.plot)").all():
        part.scroll_into_view_if_needed()
        page.wait_for_timeout(500)
        before = busy(session)
        page.evaluate(f"window.drawFrames({FRAMES})")
        yield (busy(session) - before) / FRAMES


def busy(session: Any) -> float:
    """For how long the thread of a page has worked, s."""
    metrics = session.send("Performance.getMetrics")["metrics"]
    (found,) = [metric["value"] for metric in metrics if metric["name"] == "TaskDuration"]
    return float(found)


COMMAND = Command(__doc__, add_arguments, run)

if __name__ == "__main__":
    run_command(COMMAND)
