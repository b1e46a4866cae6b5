"""Running a batch of episodes."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from _inputs.comparison import POINTS, PointEnv, Walker
from numpy.typing import NDArray

from aicon_baselines.evaluation import ComparisonError
from aicon_baselines.evaluation.rollout import Outcome, rollout


def test_what_has_ended_is_left_alone_while_the_others_go_on() -> None:
    episodes = POINTS.chunk(0, repeat=0)
    outcome = rollout(Walker(2.0), POINTS, "usual", episodes, range(8))
    assert (outcome.success ^ outcome.collision ^ (outcome.steps == POINTS.horizon)).all()

    ended = outcome.steps < POINTS.horizon
    assert ended.any()
    longer = rollout(Walker(2.0), replace(POINTS, horizon=80), "usual", episodes, range(8))
    for before, after in zip(outcome[:-1], longer[:-1], strict=True):
        np.testing.assert_array_equal(before[ended], after[ended])


def test_each_episode_is_told_once_and_as_it_ended() -> None:
    episodes = POINTS.chunk(0, repeat=0)
    told: dict[int, float] = {}

    def on_ended(outcome: Outcome, indices: NDArray[np.intp]) -> None:
        assert told.keys().isdisjoint(indices.tolist())
        told.update(zip(indices.tolist(), outcome.path_length[indices].tolist(), strict=True))

    outcome = rollout(Walker(2.0), POINTS, "usual", episodes, range(1, 8), on_ended)
    assert told == {index: outcome.path_length[index] for index in range(1, 8)}


def test_it_stops_when_the_wanted_episodes_have_ended() -> None:
    episodes = POINTS.chunk(0, repeat=0)
    all_of_them = rollout(Walker(2.0), POINTS, "usual", episodes, range(8))
    quickest = int(all_of_them.steps.argmin())

    one = rollout(Walker(2.0), POINTS, "usual", episodes, [quickest])
    assert one.steps.max() == all_of_them.steps[quickest] < all_of_them.steps.max()


@pytest.mark.parametrize("key", ["distance", "position", "is_success", "collision"])
def test_an_info_that_lacks_something_is_a_sentence(key: str) -> None:
    class Silent(PointEnv):
        def _observe(self) -> tuple[dict[str, NDArray[np.float64]], dict[str, Any]]:
            observation, info = super()._observe()
            del info[key]
            return observation, info

    task = replace(POINTS, make_env=lambda count, condition, horizon: Silent(count))
    with pytest.raises(ComparisonError, match=f"info has no {key}: .*check_task"):
        rollout(Walker(2.0), task, "usual", POINTS.chunk(0, repeat=0), range(8))
