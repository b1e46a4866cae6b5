"""An episode in which one interferes: time goes on, and so does what the policy knows."""

import math
import time

import numpy as np
import pytest
import torch

from aicon_baselines.evaluation import ComparisonError

pytest.importorskip("viser", reason="the live view needs the extra [view]")

from aicon_baselines.view import LiveEpisode, open_episode


def opened(task: str = "nav2d", steps: int = 3) -> LiveEpisode:
    """An episode after a few steps."""
    episode = open_episode(task, seed=1006)
    for _ in range(steps):
        episode.step()
    return episode


def test_it_is_the_episode_of_a_comparison() -> None:
    from aicon_baselines.agents import registry
    from aicon_baselines.tasks import load

    task, policy = load("nav2d"), registry.make("nav2d", "aicon")
    env = task.make_env(1, "range", task.horizon)
    observation, _ = env.reset(**task.reset_arguments([task.episode(1006)]))
    memory = None
    for _ in range(3):
        action, memory = policy.predict(observation, memory)
        observation, _, _, _, info = env.step(action)

    episode = opened()
    np.testing.assert_array_equal(episode.info["position"], info["position"])
    assert episode.steps == 3 and math.isclose(episode.time, 3 * task.time_step)


def test_another_resolution_takes_over_what_is_known() -> None:
    episode = opened()
    before = episode.memory

    for name in ("sum", "steepest path", "nullspace projection"):
        episode.resolve_by(name)
        assert episode.resolution == name
        for quantity in ("p_tar", "P_tar", "x_obs"):
            torch.testing.assert_close(episode.memory[quantity], before[quantity])
    episode.step()
    assert episode.steps == 4


def test_a_goal_that_is_switched_off_stays_off_in_the_next_episode() -> None:
    episode = opened()
    before = episode.memory["p_tar"]
    assert strength_of(episode, "reach") > 0.0

    episode.weigh("reach", 0.0)
    assert strength_of(episode, "reach") == 0.0
    torch.testing.assert_close(episode.memory["p_tar"], before)

    episode.start(1007)
    assert strength_of(episode, "reach") == 0.0


def strength_of(episode: LiveEpisode, goal: str) -> float:
    """The strength of the gradients that come from a goal."""
    strengths = 0.0
    for goals, strength in zip(episode.meeting.goals, episode.meeting.magnitudes[0], strict=True):
        if goal in goals:
            strengths += float(strength)
    return strengths


def test_a_target_that_is_moved_is_seen_where_it_is() -> None:
    from aicon_baselines.view.nav2d import NavigationScene
    from aicon_baselines.view.server import serve

    episode = opened()
    server = serve("127.0.0.1", 0)
    try:
        scene = NavigationScene(server, episode)
        position = episode.info["position"][0]
        target = episode.info["target"][0] + [0.1, 0.1]
        scene.move_target(target)

        np.testing.assert_allclose(episode.info["target"][0], target)
        np.testing.assert_array_equal(episode.info["position"][0], position)
        x, y = target - position
        assert episode.steps == 3
        assert float(episode.memory["z_tar"]) == pytest.approx(math.atan2(y, x), abs=0.1)

        inside = np.mean(episode.env.unwrapped.maps[0].obstacles[0], axis=0)  # type: ignore[attr-defined]
        with pytest.raises(ValueError, match="target must be outside of every obstacle"):
            scene.move_target(inside)
    finally:
        server.stop()


def test_the_compiled_policy_takes_over_and_does_the_same() -> None:
    readable, compiled = opened(steps=2), opened(steps=2)
    compiled.compile()
    for _ in range(6000):
        if compiled.compiled:
            break
        time.sleep(0.01)
    assert compiled.compiled

    for _ in range(3):
        readable.step()
        compiled.step()
    np.testing.assert_allclose(compiled.info["position"], readable.info["position"], atol=1e-9)
    torch.testing.assert_close(compiled.trace.costs, readable.trace.costs)


@pytest.mark.slow
def test_a_second_rule_is_compiled_after_the_first() -> None:
    """Torch crashes where a thread that has compiled has ended, and another one compiles."""
    episode = opened(steps=1)
    episode.compile()
    for name in episode.resolutions[:2]:
        episode.resolve_by(name)
        for _ in range(6000):
            if episode.compiled:
                break
            time.sleep(0.01)
        assert episode.compiled


def test_a_wall_that_is_moved_leaves_the_rest_where_it_was() -> None:
    from aicon_baselines.view.nav2d import NavigationScene
    from aicon_baselines.view.server import serve

    episode = opened()
    server = serve("127.0.0.1", 0)
    try:
        wall = NavigationScene(server, episode).handles()["wall"]
        before = episode.info["position"][0].copy(), episode.info["target"][0].copy()
        elsewhere = wall.where() + np.array([0.2, 0.1, 0.0])
        wall.move(elsewhere)
        np.testing.assert_allclose(wall.where(), elsewhere)
        np.testing.assert_array_equal(episode.info["position"][0], before[0])
        np.testing.assert_array_equal(episode.info["target"][0], before[1])
    finally:
        server.stop()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"task_name": "fly"}, "unknown task 'fly'; valid tasks: nav2d"),
        ({"task_name": "nav2d", "policy": "oracle"}, "unknown policy 'oracle'"),
        ({"task_name": "nav2d", "policy": "bug2"}, "'bug2' has no gradients to show"),
        ({"task_name": "nav2d", "condition": "rain"}, "unknown condition 'rain'"),
        ({"task_name": "nav2d", "seed": -1}, "seed must be 0 or more"),
    ],
)
def test_what_cannot_be_watched_is_said(arguments: dict[str, str], message: str) -> None:
    with pytest.raises(ComparisonError, match=message):
        open_episode(**arguments)  # type: ignore[arg-type]
