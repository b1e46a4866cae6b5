"""Recordings: pages that play without a server, as it was."""

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("viser", reason="the live view needs the extra [view]")
pytest.importorskip("playwright", reason="the browser is driven by playwright")

from _browser import colors_of, opened, picture_of, wait_until
from playwright.sync_api import Browser, Page

from aicon_baselines.view import open_episode, record_html


def test_a_recording_plays_from_its_file(tmp_path: Path, browser: Browser) -> None:
    episode = open_episode("nav2d", seed=1006)
    file = tmp_path / "episode.html"
    file.write_text(record_html(episode, duration=1.5), encoding="utf-8")

    with opened(browser, file.as_uri()) as page:
        wait_until(lambda: colors_of(page) > 50)

        # To its end, and back to its start, as the robot went.
        start = place_at(page, 0.0)
        end = place_at(page, 1.5)
        again = place_at(page, 0.0)

    assert np.linalg.norm(end - start) > 5.0
    np.testing.assert_allclose(again, start, atol=2.0)


def place_at(page: Page, time: float) -> np.ndarray:
    """Where the robot is on the screen at a time of the recording, px, once the picture rests."""
    box = page.locator("input").first
    box.fill(f"{time:g}")
    box.press("Enter")

    places = [np.zeros(2), np.ones(2)]

    def rests() -> bool:
        page.wait_for_timeout(300)
        places.append(place_of_robot(picture_of(page)))
        return bool(np.allclose(places[-1], places[-2], atol=0.2))

    wait_until(rests)
    return places[-1]


def place_of_robot(picture: np.ndarray) -> np.ndarray:
    """The middle of what is painted in the robot's blue, px."""
    red, green, blue = (picture[..., channel].astype(int) for channel in range(3))
    rows, columns = np.nonzero((blue - red > 90) & (blue - green > 40) & (green > red))
    return np.array([columns.mean(), rows.mean()]) if len(rows) else np.full(2, -1.0)
