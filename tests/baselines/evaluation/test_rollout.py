"""Running a batch of episodes."""

from dataclasses import replace

import numpy as np
from _inputs.comparison import POINTS, Walker

from aicon_baselines.evaluation.rollout import rollout


def test_what_has_ended_is_left_alone_while_the_others_go_on() -> None:
    episodes = POINTS.chunk(0, repeat=0)
    finished: list[int] = []
    outcome = rollout(Walker(2.0), POINTS, "usual", episodes, range(8), finished.append)
    assert sum(finished) == 8
    assert (outcome.success ^ outcome.collision ^ (outcome.steps == POINTS.horizon)).all()

    ended = outcome.steps < POINTS.horizon
    assert ended.any()
    longer = rollout(Walker(2.0), replace(POINTS, horizon=80), "usual", episodes, range(8))
    for before, after in zip(outcome[:-1], longer[:-1], strict=True):
        np.testing.assert_array_equal(before[ended], after[ended])


def test_it_stops_when_the_wanted_episodes_have_ended() -> None:
    episodes = POINTS.chunk(0, repeat=0)
    all_of_them = rollout(Walker(2.0), POINTS, "usual", episodes, range(8))
    quickest = int(all_of_them.steps.argmin())

    one = rollout(Walker(2.0), POINTS, "usual", episodes, [quickest])
    assert one.steps.max() == all_of_them.steps[quickest] < all_of_them.steps.max()
