"""The loop of an episode."""

from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import gymnasium
import numpy as np
from _inputs.comparison import POINTS, Walker
from gymnasium.wrappers import TimeLimit

from aicon_baselines.evaluation.episodes import Step, run_episodes


class Attentive(Walker):
    """Walks, and notes when episodes begin."""

    def __init__(self) -> None:
        super().__init__(speed=2.0)
        self.starts: list[Any] = []

    def predict(self, observation: Any, state: Any = None, **told: Any) -> Any:
        self.starts.append(told["episode_start"])
        return super().predict(observation, state, **told)


def rest(observation: Any, state: Any, episode_start: Any, deterministic: bool) -> Any:
    """Choose to stay, and remember nothing."""
    return np.zeros(2), None


class Rest(gymnasium.Env[Any, Any]):
    """A world in which nothing happens."""

    def reset(self, **_: Any) -> Any:
        return np.zeros(2), {"now": 0}

    def step(self, action: Any) -> Any:
        return np.ones(2), 0.0, False, False, {"now": 1}


def steps_of_points(policy: Walker | None = None) -> list[Step]:
    """All steps of a chunk of the walking points."""
    episodes = POINTS.chunk(0, repeat=0)
    env = POINTS.make_env(len(episodes), "usual", POINTS.horizon)
    start = env.reset(**POINTS.reset_arguments(episodes))
    return list(run_episodes(policy or Walker(2.0), env, start))


def test_each_episode_runs_until_it_ends_and_ends_once() -> None:
    steps = steps_of_points()
    assert (np.sum([step.ended for step in steps], axis=0) == 1).all()
    for now, then in pairwise(steps):
        np.testing.assert_array_equal(then.running, now.running & ~now.ended)


def test_a_step_begins_where_the_last_one_led() -> None:
    steps = steps_of_points()
    for now, then in pairwise(steps):
        assert then.before is now.info


def test_an_ended_episode_begins_afresh_at_every_step() -> None:
    policy = Attentive()
    first, *others = steps_of_points(policy)

    assert first.running.all()
    assert policy.starts[0].all()
    for step, starts in zip(others, policy.starts[1:], strict=True):
        np.testing.assert_array_equal(starts, ~step.running)


def test_a_single_environment_needs_no_batch() -> None:
    env = TimeLimit(Rest(), 3)
    steps = list(run_episodes(SimpleNamespace(predict=rest), env, env.reset()))
    assert [bool(step.ended) for step in steps] == [False, False, True]
    assert [step.before["now"] for step in steps] == [0, 1, 1]
