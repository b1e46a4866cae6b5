"""The page of twenty lines in docs/export.md runs README's graph."""

import shutil
import threading
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import pytest
from _documents import ROOT, blocks
from _pages import until
from playwright.sync_api import Page

pytestmark = pytest.mark.slow

ROBOT = """
() => {
    const canvas = document.querySelector("canvas");
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    for (let i = 0; i < data.length; i += 4)
        if (data[i + 2] > data[i + 1]) // blue or purple
            return [(i / 4) % canvas.width, Math.floor(i / 4 / canvas.width)];
    return null;
}
"""
"""JavaScript that returns where the first dot of the robot is painted, px, if it is yet."""


def robot(page: Page) -> Any:
    """Where the robot is painted, (x, y) in px."""
    return page.evaluate(ROBOT)


def test_the_graph_of_readme_runs_in_a_page_of_twenty_lines(tmp_path: Path, browser: Any) -> None:
    pytest.importorskip("ziglang", reason="no ziglang (pip install ziglang)")
    (graph,) = [b.code for b in blocks(ROOT / "README.md", "python") if "def leash" in b.code]
    made: dict[str, Any] = {}
    exec(graph, made)
    made["policy"].export(tmp_path / "follow.wasm")

    (page_of_own,) = [block.code for block in blocks(ROOT / "docs" / "export.md", "html")]
    (tmp_path / "follow.html").write_text(page_of_own)
    shutil.copy(ROOT / "examples" / "web" / "aicon_policy.mjs", tmp_path)

    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(tmp_path)))
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    try:
        page = browser.new_page()
        complaints: list[str] = []
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.goto(f"http://127.0.0.1:{server.server_port}/follow.html")
        until(lambda: robot(page) and robot(page)[0] > 320, "the robot does not go to its leader")
        page.locator("canvas").hover(position={"x": 100, "y": 100})
        until(lambda: max(robot(page)) < 200, "the robot does not follow the pointer")
        assert complaints == []
        page.close()
    finally:
        server.shutdown()
        server.server_close()
        thread.join()


class Quiet(SimpleHTTPRequestHandler):
    """Serves files, and says nothing."""

    def log_message(self, format: str, *words: Any) -> None:
        """Say nothing."""
