"""The page in a real browser, without a display."""

import io
import os
import shutil
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from PIL import Image

pytest.importorskip("viser", reason="the live view needs the extra [view]")
pytest.importorskip("playwright", reason="the browser is driven by playwright")

from playwright.sync_api import Page, sync_playwright

from aicon_baselines.view import LiveView, open_episode

SEED = 1006
BROWSER = shutil.which("chromium") or shutil.which("chromium-browser")
REQUIRED = os.environ.get("AICON_BROWSER") == "required"
ARGUMENTS = [
    "--no-sandbox",
    "--disable-dev-shm-usage",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
]


@pytest.fixture(scope="module")
def view() -> Iterator[LiveView]:
    """A page that is served while the tests run; its episode rests."""
    if BROWSER is None and not REQUIRED:
        pytest.skip("there is no chromium here")

    view = LiveView(open_episode("nav2d", seed=SEED), port=0, paused=True)
    thread = threading.Thread(target=view.run)
    thread.start()
    yield view

    view.stop()
    thread.join()
    view.close()


@pytest.fixture(scope="module")
def page(view: LiveView) -> Iterator[Page]:
    """The page, loaded."""
    assert BROWSER is not None, "there is no chromium here"
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=BROWSER, args=ARGUMENTS)
        page = browser.new_page(viewport={"width": 1000, "height": 700})
        page.set_default_timeout(60_000)
        page.goto(f"http://127.0.0.1:{view.port}")
        page.get_by_role("button", name="Reset").wait_for()
        yield page
        browser.close()


def wait_until(condition: Callable[[], bool]) -> None:
    """Wait for what a click brings about, patiently: the machine may be busy."""
    for _ in range(1200):
        if condition():
            return
        time.sleep(0.05)
    raise AssertionError("it did not happen")


def colors_of(page: Page) -> int:
    """Number of colours that the world is painted in."""
    picture = Image.open(io.BytesIO(page.locator("canvas").first.screenshot()))
    return len(np.unique(np.asarray(picture.convert("RGB")).reshape(-1, 3), axis=0))


def test_the_world_is_painted_and_named(page: Page) -> None:
    wait_until(lambda: colors_of(page) > 50)
    for words in ("target", "reach the target", "In conflict", "strength of the gradients"):
        assert page.get_by_text(words, exact=True).count() > 0, words


def test_a_step_is_one_step(page: Page, view: LiveView) -> None:
    before = view.episode.steps
    page.get_by_role("button", name="Step", exact=True).click()
    wait_until(lambda: view.episode.steps > before)
    assert view.episode.steps == before + 1


def test_the_button_starts_and_pauses(page: Page, view: LiveView) -> None:
    before = view.episode.steps
    page.get_by_role("button", name="Play").click()
    wait_until(lambda: view.episode.steps > before + 2)

    page.get_by_role("button", name="Pause").click()
    wait_until(lambda: not view.running)
    resting = view.episode.steps
    time.sleep(0.5)
    assert view.episode.steps == resting


def test_a_goal_that_is_switched_off_changes_what_the_robot_does(
    page: Page, view: LiveView
) -> None:
    def motion(of: Any) -> Any:
        return of.trace.values["a"][0].numpy(force=True)

    page.get_by_role("button", name="Reset").click()
    wait_until(lambda: view.episode.steps == 0)
    page.get_by_label("reach", exact=True).click(force=True)
    wait_until(lambda: float(view.episode.memory["goals/active"][0, 0]) == 0.0)
    page.get_by_role("button", name="Step", exact=True).click()
    wait_until(lambda: view.episode.steps == 1)

    reference = open_episode("nav2d", seed=SEED)
    reference.step()
    assert np.linalg.norm(motion(view.episode) - motion(reference)) > 0.05
