"""What happened in an episode, kept step by step."""

from types import SimpleNamespace
from typing import Any

import gymnasium
import numpy as np
import pytest
import torch
from gymnasium.wrappers import TimeLimit

from aicon_baselines.agents.registry import factory
from aicon_baselines.evaluation.recording import Recording, record, to_array, true_intervals
from aicon_baselines.tasks import load


class Counter(gymnasium.Env[Any, Any]):
    """A world that counts its steps, and has arrived after the ninth."""

    def reset(self, **_: Any) -> Any:
        self.now = 0
        return np.array([0.0]), {"now": 0, "is_success": False}

    def step(self, action: Any) -> Any:
        self.now += 1
        arrived = self.now == 9
        return np.array([self.now]), 0.0, arrived, False, {"now": self.now, "is_success": arrived}


def remember(observation: Any, state: Any, **_: Any) -> Any:
    """Do nothing, and remember what is seen now."""
    return None, float(observation[0])


def recorded(horizon: int | None = None, **options: Any) -> Any:
    """An episode of the counting world, as plain fields."""

    def keep(policy: Any, memories: Any, success: bool, infos: Any, pictures: Any, *_: Any) -> Any:
        told = [info["now"] for info in infos]
        return SimpleNamespace(memories=memories, success=success, told=told, seen=pictures)

    policy = SimpleNamespace(predict=remember)
    kept: Any = keep
    return record(kept, policy, TimeLimit(Counter(), 20), {"seed": 0}, horizon, **options)


def test_every_memory_has_what_was_told_with_it_and_one_is_told_in_the_end() -> None:
    episode = recorded()
    assert episode.memories == list(range(9))
    assert episode.told == list(range(10))
    assert episode.success


def test_of_a_long_episode_every_few_steps_are_kept() -> None:
    episode = recorded(stride=4)
    assert episode.memories == [0, 4, 8]
    assert episode.told == [0, 4, 8, 9]


def test_pictures_are_of_the_start_of_every_few_steps_and_of_the_end() -> None:
    assert recorded(look=lambda seen: int(seen[0]), stride=4).seen == [0, 4, 8, 9]


def test_it_ends_at_the_horizon() -> None:
    episode = recorded(horizon=3)
    assert episode.told == [0, 1, 2, 3]
    assert not episode.success


def test_what_it_would_do_after_the_end_is_kept_where_it_is_asked_for() -> None:
    assert recorded(beyond=True).memories == list(range(10))


@pytest.mark.parametrize(
    ("mask", "intervals"),
    [
        ([], []),
        ([0, 0], []),
        ([1, 1], [(0, 2)]),
        ([0, 1, 1, 0, 1], [(1, 3), (4, 5)]),
    ],
)
def test_true_intervals(mask: list[int], intervals: list[tuple[int, int]]) -> None:
    assert true_intervals(np.array(mask, dtype=bool)) == intervals


def test_arrays_are_doubles() -> None:
    array = to_array(torch.ones(2, dtype=torch.float32, requires_grad=True))
    assert array.dtype == np.float64


@pytest.mark.parametrize("condition", ["dropout", "delay"])
def test_who_filters_the_log_of_a_recording_believes_what_the_policy_believed(
    condition: str,
) -> None:
    pytest.importorskip("pymunk")
    task, policy = load("pusht"), factory("pusht", "aicon", **{"law.iterations": 2})(condition)
    env, reset = task.make_env(1, condition, 12), task.reset_arguments([task.episode(1001)])
    recording = record(Recording, policy, env, reset, 12)
    assert bool(recording.log[0]["z_keypoints"].isnan().any()) == (condition == "dropout")

    estimates = recording.policy.model.filter(*recording.log).estimates
    for name, series in estimates.items():
        torch.testing.assert_close(series, recording.memory[name], rtol=1e-9, atol=1e-12)
