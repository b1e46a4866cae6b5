"""How often the pages draw, what a frame costs, and when they first move, on a slow processor.

Chromium slows its page down to a quarter. Every frame is the browser's own, and while they are
counted a mouse drags what the screen has to be dragged, so that nothing comes to rest. Where there
is no graphics card, the thread of the page also paints the pictures: the second cost has it.

Example: python docs/web/time_frames.py
"""

import argparse
import shutil
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from itertools import pairwise
from pathlib import Path
from typing import Any

from playwright.sync_api import Browser, Locator, Page, sync_playwright

from aicon_baselines.cli.command_line import Command, add_option, run_command
from make_pages import make_pages

PHONE = {"viewport": {"width": 390, "height": 844}, "device_scale_factor": 3, "is_mobile": True}

WATCH = """
    // Costs of a frame, ms: those of its callbacks, and of all until the thread is free again.
    const request = window.requestAnimationFrame.bind(window), free = new MessageChannel();
    const watched = (window.watched = { at: [], scripts: [], all: [], moved: null });
    let begun = 0;
    free.port1.onmessage = () => watched.all.push(performance.now() - begun);
    window.requestAnimationFrame = (draw) => request((now) => {
        const before = performance.now();
        if (now !== watched.at.at(-1)) {
            begun = before;
            watched.at.push(now);
            watched.scripts.push(0);
            free.port2.postMessage(null);
        }
        draw(now);
        watched.scripts[watched.scripts.length - 1] += performance.now() - before;
    });

    // When the first picture has changed: ms since the address was called.
    const pictures = new Set(), isStill = location.pathname.includes("theory");
    const look = () => {
        const canvas = document.querySelector("canvas[role]");
        if (canvas?.width > 1) {
            const pen = canvas.getContext("2d");
            const { data } = pen.getImageData(0, 0, canvas.width, canvas.height);
            const dots = new Int32Array(data.buffer);
            if (data[3]) pictures.add(dots.reduce((sum, dot) => (31 * sum + dot) | 0));
        }
        if (pictures.size > (isStill ? 0 : 1)) watched.moved = performance.now();
        else request(look);
    };
    request(look);
"""
"""What a page tells of its frames.

The first screen of the theory stands still until it is turned: there, it is drawn.
"""

DRAG = """(held, seconds) => {
    const { left, top } = held.getBoundingClientRect(), begin = performance.now();
    const move = (now) => {
        const time = (now - begin) / 1000, [right, down] = [Math.sin(2 * time), Math.sin(3 * time)];
        if (time > seconds) return;
        const place = { clientX: left + 30 * right, clientY: top + 30 * down };
        held.dispatchEvent(new PointerEvent("pointermove", place));
        if (held.type === "range") held.valueAsNumber = 6 + 5 * right;
        held.dispatchEvent(new Event("input"));
        requestAnimationFrame(move);
    };
    requestAnimationFrame(move);
}"""
"""Moves what is held once in every frame."""

WORK = """() => {
    const begin = performance.now();
    for (let i = 0, x = 0; i < 3e7; ++i) x += Math.sqrt(i);
    return performance.now() - begin;
}"""
"""How long some work takes, ms."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare on what the pages are looked at."""
    add_option(parser, "--slower", 4.0, "how many times")
    add_option(parser, "--seconds", 10.0, "for each screen")
    parser.add_argument("--phone", action="store_true", help="a phone's screen, three dots a pixel")


def run(arguments: argparse.Namespace) -> None:
    """Print when each page moves, and a line for each of its screens."""
    with tempfile.TemporaryDirectory() as made, sync_playwright() as playwright:
        folder = Path(made)
        make_pages(folder)

        chromium = shutil.which("chromium") or shutil.which("chromium-browser")
        browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        look = PHONE if arguments.phone else {}
        with served(folder) as server:
            for path in sorted(folder.glob("*.html")):
                print(path.stem)
                for place in (f"{server}/{path.name}", path.as_uri()):
                    for slower in (1.0, arguments.slower):
                        with opened(browser, place, slower, look) as page:
                            moved = f"moves after {page.evaluate('watched.moved'):.0f} ms"
                            print(f"  {place[:4]}, {slower:g} times slower: {moved}")
                with opened(browser, path.as_uri(), 1.0, look) as page:
                    slow_down(page, arguments.slower)
                    print_frames(page, path.stem, arguments.seconds)


def slow_down(page: Page, slower: float) -> None:
    """Slow a page down, and say how much slower it is, for other work may slow it down as well."""
    page.wait_for_timeout(2000)  # until every screen is there
    before = page.evaluate(WORK)
    session = page.context.new_cdp_session(page)
    session.send("Emulation.setCPUThrottlingRate", {"rate": slower})
    now = page.evaluate(WORK)
    print(f"  {now / before:.1f} times slower: {now:.0f} ms for what took {before:.0f}")


def print_frames(page: Page, name: str, seconds: float) -> None:
    """Print a line for each screen of a page."""
    for part in page.locator(".stage:not(.plot)").all():
        root = part.locator("xpath=ancestor::section")
        part.scroll_into_view_if_needed()
        page.wait_for_timeout(1000)
        page.evaluate("for (const kind of ['at', 'scripts', 'all']) watched[kind].length = 0")
        drag(page, root.locator(".handle, input[type=range]").first, seconds)

        found = page.evaluate("watched")
        times = found["at"]
        rate = 1000 * (len(times) - 1) / (times[-1] - times[0])
        late = sum(later - earlier > 25 for earlier, later in pairwise(times))
        scripts, whole = (spread(found[kind]) for kind in ("scripts", "all"))
        print(
            f"  {root.get_attribute('id') or name}: {rate:.1f} frames a second, {late} of "
            f"{len(times)} late; scripts {scripts} ms, with painting {whole} ms",
            flush=True,
        )


def spread(costs: list[float]) -> str:
    """The median, the 95th percentile and the largest."""
    ordered = sorted(costs)
    return " / ".join(f"{ordered[int(share * (len(ordered) - 1))]:.1f}" for share in (0.5, 0.95, 1))


def drag(page: Page, handle: Locator, seconds: float) -> None:
    """Drag something about: a mouse takes hold of it, and moves once in every frame."""
    handle.hover()
    page.mouse.down()
    handle.evaluate(DRAG, seconds)
    page.wait_for_timeout(1000 * seconds)
    page.mouse.up()


@contextmanager
def opened(browser: Browser, place: str, slower: float, look: dict[str, Any]) -> Iterator[Page]:
    """A page on a slow processor, which has moved."""
    context = browser.new_context(**look)
    page = context.new_page()
    page.add_init_script(WATCH)
    session = context.new_cdp_session(page)
    session.send("Emulation.setCPUThrottlingRate", {"rate": slower})
    page.goto(place)
    page.wait_for_function("watched.moved")
    yield page
    context.close()


@contextmanager
def served(folder: Path) -> Iterator[str]:
    """The address of a server of a folder."""
    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(folder)))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_port}"
    server.shutdown()
    server.server_close()


class Quiet(SimpleHTTPRequestHandler):
    """Serves files, and says nothing."""

    def log_message(self, format: str, *words: Any) -> None:
        """Say nothing."""


COMMAND = Command(__doc__, add_arguments, run)

if __name__ == "__main__":
    run_command(COMMAND)
