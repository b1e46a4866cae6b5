"""A short version of the table of faults: on readings that stay wrong, robots come to rest."""

import os
import shutil

import pytest

import standing
from aicon_baselines.evaluation import ComparisonError
from aicon_baselines.evaluation.task import Task
from aicon_baselines.tasks import load
from aicon_torch import Policy, make_policy

pytestmark = pytest.mark.skipif(
    not shutil.which(os.environ.get("CXX", "g++")), reason="there is no C++ compiler"
)


def compiled(task: Task, condition: str) -> Policy:
    return make_policy(task.name, **task.policy_options(condition)).compile()


SLOW = pytest.mark.slow


@pytest.mark.parametrize(
    ("name", "episodes", "horizon"),
    [("nav2d", 17, 250), pytest.param("pusht", 10, 80, marks=SLOW)],
)
@pytest.mark.parametrize(
    "besides", ["", pytest.param("+late", marks=SLOW), pytest.param("+jitter", marks=SLOW)]
)
def test_it_rests_and_nothing_is_hit(
    name: str, episodes: int, horizon: int, besides: str, longest: float = 0.3
) -> None:
    """However late readings are while they come."""
    task = load(name)
    policy = compiled(task, f"gone{besides}")
    for fault in (f"gone{besides}", f"erratic{besides}"):
        seeds = list(range(1000, 1000 + episodes))
        times, collisions = standing.rest(policy, task, fault, seeds, horizon)
        assert len(times) > 0 and collisions == 0
        assert times.max() * task.time_step <= longest + 1e-9


@pytest.mark.parametrize(("fault", "message"), [("fog", "unknown condition"), ("late", "passes")])
def test_a_fault_that_passes_is_refused(fault: str, message: str) -> None:
    with pytest.raises(ComparisonError, match=message):
        standing.check_fault(load("nav2d"), fault)
