"""Recordings: pages that play without a server, as it was."""

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("viser", reason="the live view needs the extra [view]")
pytest.importorskip("playwright", reason="the browser is driven by playwright")

from _browser import opened, picture_of, wait_until
from playwright.sync_api import Browser, Page

from aicon_baselines.view import open_episode, record_html

FRAMES_PAINTED = """
(count) => new Promise((resolve) => {
    const step = (left) => left ? requestAnimationFrame(() => step(left - 1)) : resolve();
    step(count);
})
"""
"""JavaScript that returns once the page has painted so many frames, however slow it paints."""


@pytest.mark.slow
def test_a_recording_plays_from_its_file(tmp_path: Path, browser: Browser) -> None:
    episode = open_episode("nav2d", seed=1006)
    first = episode.info["position"][0].copy()
    file = tmp_path / "episode.html"
    file.write_text(record_html(episode, duration=4.0), encoding="utf-8")
    went = episode.info["position"][0] - first

    with opened(browser, file.as_uri()) as page:
        page.set_viewport_size({"width": 900, "height": 800})  # the robot is a few pixels wide
        page.locator("canvas").first.wait_for()
        end = place_at(page, 4.0)
        start = place_at(page, 0.0)

    # It went on the screen, where y points down, as it went in the world.
    moved = (end - start) * np.array([1.0, -1.0])
    assert np.linalg.norm(moved) > 5.0
    assert moved @ went > 0.97 * np.linalg.norm(moved) * np.linalg.norm(went)


def place_at(page: Page, time: float) -> np.ndarray:
    """Where the robot is on the screen at a time of the recording, px, once the picture rests."""
    box = page.locator("input").first

    def shows_the_time() -> bool:  # a recording that plays may take it away once more
        box.fill(f"{time:g}")
        box.press("Enter")
        page.evaluate(FRAMES_PAINTED, 10)
        return float(box.input_value()) == time

    wait_until(shows_the_time)
    places = [np.full(2, -1.0)]

    def rests() -> bool:
        page.evaluate(FRAMES_PAINTED, 10)
        places.append(place_of_robot(picture_of(page)))
        last = np.stack(places[-4:])
        return bool(len(places) > 4 and last.min() >= 0.0 and np.ptp(last, axis=0).max() < 0.2)

    wait_until(rests)
    return places[-1]


def place_of_robot(picture: np.ndarray) -> np.ndarray:
    """The middle of what is painted in the robot's blue, px."""
    red, green, blue = (picture[..., channel].astype(int) for channel in range(3))
    rows, columns = np.nonzero((blue - red > 90) & (blue - green > 40) & (green > red))
    return np.array([columns.mean(), rows.mean()]) if len(rows) else np.full(2, -1.0)
