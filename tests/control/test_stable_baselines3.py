"""Policies in the loops of others.

Evaluate_policy, vector environments of both kinds, nothing privileged.
"""

import copy
from collections.abc import Callable
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
import torch
from _inputs import driven
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from numpy.typing import NDArray

import aicon_envs  # noqa: F401  (registers the environments)
from aicon_torch import Policy

sb3 = pytest.importorskip("stable_baselines3")


evaluation = pytest.importorskip("stable_baselines3.common.evaluation")


vec_env = pytest.importorskip("stable_baselines3.common.vec_env")


ID = "aicon/Nav2D-v0"


POST = [(0.8, -0.1), (1.0, -0.1), (1.0, 0.15), (0.8, 0.15)]


LIMITS = (5, 7, 12)


class Here(gym.Wrapper[Any, Any, Any, Any]):
    """Every episode on one small map."""

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> Any:
        here = {"obstacles": [POST], "start": (0.0, 0.0), "target": (1.5, 0.2)}
        return super().reset(seed=seed, options=here | (options or {}))


def small(limit: int = 400) -> gym.Env[Any, Any]:
    return Here(gym.make(ID, max_episode_steps=limit))


def maker(limit: int) -> Callable[[], gym.Env[Any, Any]]:
    return lambda: small(limit)


def test_evaluate_policy_runs_on_a_plain_environment() -> None:
    env = small()
    env.reset(seed=0)
    rewards, lengths = evaluation.evaluate_policy(
        driven("nav2d"), env, n_eval_episodes=2, return_episode_rewards=True, warn=False
    )

    assert len(rewards) == 2
    assert all(reward > 1.3 + 1.0 - 0.2 for reward in rewards)  # it came 1.3 m nearer and arrived
    assert all(20 < length < 400 for length in lengths)


def test_evaluate_policy_runs_on_any_map() -> None:
    env = gym.make(ID, map="clutter", max_episode_steps=30)
    mean, _ = evaluation.evaluate_policy(driven("nav2d"), env, n_eval_episodes=1, warn=False)
    assert np.isfinite(mean)


def test_evaluate_policy_runs_on_a_vector_environment() -> None:
    envs = vec_env.DummyVecEnv([maker(400)] * 3)
    envs.seed(1)
    rewards, _ = evaluation.evaluate_policy(
        driven("nav2d"), envs, n_eval_episodes=5, return_episode_rewards=True, warn=False
    )

    assert len(rewards) == 5 and all(reward > 2.0 for reward in rewards)


Record = list[tuple[dict[str, NDArray[Any]], NDArray[np.bool_], NDArray[Any]]]


def same_step(policy: Policy, steps: int) -> Record:
    """stable-baselines3's loop.

    The observation after the last of an episode is the first of the next.
    """
    envs = vec_env.DummyVecEnv([maker(limit) for limit in LIMITS])
    envs.seed(0)
    observation, memory, done = envs.reset(), None, np.ones(3, dtype=bool)
    record: Record = []

    for _ in range(steps):
        action, memory = policy.predict(observation, memory, episode_start=done)
        record.append((copy.deepcopy(dict(observation)), done.copy(), action))
        observation, _, done, _ = envs.step(action)

    return record


def gymnasium_loop(policy: Policy, envs: Any, steps: int, seed: int) -> Record:
    """Gymnasium's loop.

    The last observation comes first; the step after it, whose action is ignored, starts anew.
    """
    observation, _ = envs.reset(seed=seed)
    memory: Any = None
    done, before = np.zeros(3, dtype=bool), np.ones(3, dtype=bool)
    record: Record = []

    for _ in range(steps):
        action, memory = policy.predict(observation, memory, episode_start=before)
        record.append((copy.deepcopy(observation), before.copy(), action))
        observation, _, terminated, truncated, _ = envs.step(action)
        before, done = done, terminated | truncated

    return record


def next_step(policy: Policy, steps: int) -> Record:
    """The same, in a vector environment that starts anew in the step after the last."""
    makers = [maker(limit) for limit in LIMITS]
    envs = SyncVectorEnv(makers, autoreset_mode=AutoresetMode.NEXT_STEP)
    return gymnasium_loop(policy, envs, steps, seed=0)


Episode = list[tuple[dict[str, NDArray[Any]], NDArray[Any]]]
"""Observation and action of each step."""


def episodes(record: Record, row: int) -> list[Episode]:
    """The episodes of one row."""
    pieces: list[Episode] = []

    for observation, start, action in record:
        if start[row]:
            pieces.append([])
        alone = {key: value[row] for key, value in observation.items()}
        pieces[-1].append((alone, action[row]))

    return pieces


def assert_starts_afresh(policy: Policy, episode: Episode) -> None:
    """The actions are those of a single robot that starts at the first observation."""
    memory: Any = None

    for observation, action in episode:
        alone, memory = policy.predict(observation, memory)
        assert np.allclose(alone, action, rtol=1e-6, atol=1e-7)


@pytest.mark.parametrize(
    ("loop", "extra"),
    [(same_step, 0), (next_step, 1)],
    ids=["stable-baselines3", "gymnasium NEXT_STEP"],
)
@pytest.mark.parametrize("preset", ["aicon", "paper_literal"])
def test_each_episode_starts_from_a_fresh_memory_once(loop: Any, extra: int, preset: str) -> None:
    policy = driven("nav2d", preset=preset)
    record = loop(policy, 40)

    for row, limit in enumerate(LIMITS):
        pieces = episodes(record, row)
        assert {len(piece) for piece in pieces[:-1]} == {limit + extra}

        for piece in pieces:
            assert_starts_afresh(policy, piece)


def test_the_native_vector_environment_gives_the_same() -> None:
    """The environment's own batch, whose episodes are cut by a time limit of 9 steps."""
    policy = driven("nav2d")
    envs = gym.make_vec(ID, num_envs=3, max_episode_steps=9, map="long_wall")
    record = gymnasium_loop(policy, envs, steps=25, seed=3)

    for row in range(3):
        pieces = episodes(record, row)
        assert [len(piece) for piece in pieces] == [10, 10, 5]

        for piece in pieces:
            assert_starts_afresh(policy, piece)


def scramble(attributes: dict[str, Any], rng: np.random.Generator) -> None:
    """Overwrite every array of numbers."""
    for value in attributes.values():
        if isinstance(value, np.ndarray) and value.dtype.kind == "f":
            value[...] = rng.normal(size=value.shape)


@pytest.mark.parametrize("preset", ["aicon", "paper_literal", "steepest", "potential_field"])
def test_what_the_policy_does_not_sense_does_not_change_what_it_does(preset: str) -> None:
    """Everything in info, and all that the environment hides, is changed before each decision."""
    rng = np.random.default_rng(0)
    policy = disturbed = driven("nav2d", preset=preset)
    env = small()
    hidden = vars(vars(env.unwrapped)["_batch"])
    observation, info = env.reset(seed=0)
    memory: Any = None
    other: Any = None

    for _ in range(60):
        action, memory = policy.predict(observation, memory)

        seen, kept = copy.deepcopy(observation), copy.deepcopy(hidden["_simulation"])
        scramble(vars(hidden["_simulation"]), rng)
        for key, value in info.items():
            info[key] = rng.normal(size=np.shape(value))

        more = {"info": info, "position": info["position"]}
        found, other = disturbed.predict(seen | more, other)
        assert np.array_equal(found, action)

        hidden["_simulation"] = kept
        observation, _, terminated, _, info = env.step(action)
        if terminated:
            break

    assert all(torch.equal(memory[key], other[key]) for key in memory)
