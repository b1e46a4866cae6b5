"""Episodes that have ended stay in their batch, also where readings get lost."""

from _inputs import driven

from aicon_baselines.evaluation.rollout import rollout
from aicon_baselines.evaluation.task import Episode
from aicon_baselines.tasks import load


def test_an_ended_episode_does_not_stop_the_others_when_its_readings_get_lost() -> None:
    task = load("pusht")
    episodes = [Episode(seed, 0, task.maps[0]) for seed in (1001, 1003, 1004)]
    policy = driven("pusht", **task.policy_options("dropout"))

    outcome = rollout(policy, task, "dropout", episodes, [1001, 1003, 1004])

    assert outcome.success.all() and len(set(outcome.steps)) > 1
