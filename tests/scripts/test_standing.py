"""A short version of the table of faults: on readings that stay wrong, robots come to rest."""

import os
import shutil

import pytest

import standing
from aicon_baselines.evaluation.task import Task
from aicon_baselines.tasks import load
from aicon_torch import Policy, make_policy

pytestmark = pytest.mark.skipif(
    not shutil.which(os.environ.get("CXX", "g++")), reason="there is no C++ compiler"
)


def compiled(task: Task, condition: str) -> Policy:
    return make_policy(task.name, **task.policy_options(condition)).compile()


@pytest.mark.parametrize(
    ("name", "episodes", "horizon", "longest"),
    [("nav2d", 17, 250, 0.3), ("pusht", 10, 80, 0.3)],
)
def test_it_rests_and_nothing_is_hit(
    name: str, episodes: int, horizon: int, longest: float
) -> None:
    task = load(name)
    policy = compiled(task, "gone")
    for fault in ("gone", "erratic"):
        met = standing.rest(policy, task, fault, list(range(1000, 1000 + episodes)), horizon)
        assert len(met.times) > 0 and met.collisions == 0
        assert met.times.max() * task.time_step <= longest + 1e-9
