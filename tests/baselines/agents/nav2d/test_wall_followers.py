"""Bug 2 and the wall follower: around obstacles, out of traps, and alone as in a batch."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from aicon_baselines.agents import compiled, factory
from aicon_baselines.agents.nav2d import Bug2, WallFollower
from aicon_baselines.evaluation import ComparisonError
from aicon_baselines.evaluation.rollout import Outcome, rollout
from aicon_baselines.evaluation.task import Episode
from aicon_baselines.tasks.nav2d import TASK
from aicon_torch import OptionError

AGENTS = (Bug2, WallFollower)


def run(agent: Any, episodes: Sequence[Episode]) -> Outcome:
    """Episodes as one batch, in the usual condition."""
    seeds = [episode.seed for episode in episodes]
    return rollout(agent, TASK, "range", list(episodes), seeds)


def episodes_on(*maps: str) -> list[Episode]:
    return [Episode(2000 + index, 0, name) for index, name in enumerate(maps)]


def reading(bearing: float, clearance: float, obstacle: float) -> dict[str, NDArray[Any]]:
    values = {"bearing": bearing, "range": clearance, "obstacle_bearing": obstacle}
    return {name: np.array([[value]], np.float32) for name, value in values.items()}


@pytest.mark.parametrize("agent", AGENTS)
def test_it_gets_out_of_traps_without_touching_them(agent: Any) -> None:
    episodes = episodes_on("u_trap_2", "long_wall", "l_shape", "bug_trap", "ring_inside")
    outcome = run(agent(), episodes)
    assert outcome.success.all() and not outcome.collision.any()


@pytest.mark.slow
def test_bug_2_finds_its_way_through_mazes() -> None:
    assert run(Bug2(), episodes_on("maze", "corridors", "spiral_out")).success.all()


@pytest.mark.parametrize("agent", [Bug2, pytest.param(WallFollower, marks=pytest.mark.slow)])
def test_an_episode_goes_alone_as_it_goes_in_a_batch(agent: Any) -> None:
    episodes = episodes_on("u_trap_1", "clutter", "zigzag")
    batch = run(agent(), episodes)
    for index, episode in enumerate(episodes):
        alone = run(agent(), [episode])
        assert alone.steps[0] == batch.steps[index]
        assert alone.path_length[0] == pytest.approx(batch.path_length[index], abs=1e-6)


@pytest.mark.parametrize("agent", AGENTS)
def test_it_heads_for_the_target_unless_a_wall_is_near_and_in_the_way(agent: Any) -> None:
    to_target = [0.5 * np.cos(0.4), 0.5 * np.sin(0.4)]
    for far in (reading(0.4, 1.0, 0.4), reading(0.4, 0.05, 0.4 + np.pi)):
        action, state = agent().predict(far)
        np.testing.assert_allclose(action[0], to_target, atol=1e-6)
        assert agent().explain(state, 0) == "heads for the target"


@pytest.mark.parametrize("agent", AGENTS)
@pytest.mark.parametrize(("obstacle", "hand"), [(0.3, "left"), (-0.3, "right")])
def test_it_turns_where_the_turn_is_smaller(agent: Any, obstacle: float, hand: str) -> None:
    action, state = agent().predict(reading(0.0, 0.06, obstacle))
    heading = np.arctan2(action[0, 1], action[0, 0])
    assert abs(heading) < np.pi / 2 and np.sign(heading) == -np.sign(obstacle)
    assert f"follows the wall on its {hand}" in agent().explain(state, 0)


@pytest.mark.parametrize("agent", AGENTS)
@pytest.mark.parametrize(("clearance", "toward"), [(0.02, -1.0), (0.06, 0.0), (0.09, 1.0)])
def test_it_controls_the_clearance(agent: Any, clearance: float, toward: float) -> None:
    action, _ = agent().predict(reading(0.0, clearance, 0.3))
    component = action[0] @ [np.cos(0.3), np.sin(0.3)]
    assert np.sign(np.round(component, 6)) == toward
    assert np.linalg.norm(action[0]) == pytest.approx(0.5)


@pytest.mark.parametrize("agent", AGENTS)
def test_a_new_episode_forgets_the_wall(agent: Any) -> None:
    _, state = agent().predict(reading(0.0, 0.05, 0.1))
    assert state.is_following.all()

    far = reading(0.0, 1.0, 0.1)
    _, kept = agent().predict(far, state, np.array([False]))
    _, fresh = agent().predict(far, state, np.array([True]))
    assert kept.is_following.all() and not fresh.is_following.any()


def test_options_have_names_and_bounds() -> None:
    assert factory("nav2d", "bug2", clearance=0.2)("range") == Bug2(clearance=0.2)
    with pytest.raises(OptionError, match="Bug2 has no option 'speedy'. Options: .*speed"):
        factory("nav2d", "bug2", speedy=1.0)
    with pytest.raises(OptionError, match="clearance=0: expected a positive number"):
        factory("nav2d", "wall_follower", clearance=0)


def test_it_has_no_step_to_compile() -> None:
    with pytest.raises(ComparisonError, match="Bug2 is no policy of the library"):
        compiled(factory("nav2d", "bug2"))
