"""The page in a real browser: it shows each world, and what is clicked there happens."""

import time
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

pytest.importorskip("viser", reason="the live view needs the extra [view]")
pytest.importorskip("playwright", reason="the browser is driven by playwright")

from _browser import colors_of, wait_until, watched, weigh
from playwright.sync_api import Browser, Page

from aicon_baselines.view import LiveEpisode, LiveView, open_episode, serve

WORLDS = {
    "nav2d": ("range", 1006, "reach"),
    "arm_push": ("true_pose", 1000, "push"),
    "reach": ("panda_pose_home_ball", 1000, "reach"),
}


pytestmark = pytest.mark.slow  # without a GPU a world in space takes a minute to be painted


@pytest.fixture(scope="module", params=WORLDS)
def view(request: pytest.FixtureRequest) -> LiveView:
    """A world that rests, and once it plays goes on until it is paused, however late that is."""
    if request.param != "nav2d":
        pytest.importorskip("mujoco", reason="the arms need MuJoCo")
    condition, seed, _ = WORLDS[request.param]
    episode = open_episode(request.param, condition=condition, seed=seed)
    server = serve("127.0.0.1", 0)
    return LiveView(episode, server, paused=True, compiles=False, loops=True)


@pytest.fixture(scope="module")
def page(browser: Browser, view: LiveView) -> Iterator[Page]:
    """The page, loaded."""
    with watched(browser, view) as page:
        yield page


def test_the_world_is_painted_and_named(page: Page, view: LiveView) -> None:
    wait_until(lambda: colors_of(page) > 50)
    goals = view.episode.policy.model.goals
    for words in (*goals, "In conflict", "Gradients at", "magnitude of the gradients"):
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
    time.sleep(0.3)
    assert view.episode.steps == resting


def test_a_goal_that_is_switched_off_changes_what_the_robot_does(
    page: Page, view: LiveView
) -> None:
    _, _, goal = WORLDS[view.episode.name]
    index = list(view.episode.policy.model.goals).index(goal)
    page.get_by_role("button", name="Reset").click()
    wait_until(lambda: view.episode.steps == 0)
    before = action(view.episode)

    weigh(page, goal, 0.0)
    wait_until(lambda: float(view.episode.memory["goals/active"][0, index]) == 0.0)
    wait_until(lambda: bool(np.abs(action(view.episode) - before).max() > 0.01))


def action(episode: LiveEpisode) -> Any:
    """The action that was chosen, (n,)."""
    (actuator,) = episode.policy.model.actuators
    return episode.trace.values[actuator][0].numpy(force=True)
