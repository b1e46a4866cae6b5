"""The loop of every episode: the policy sees and chooses, the environment goes on."""

import copy
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import gymnasium
import numpy as np
from gymnasium.vector import VectorEnv
from numpy.typing import NDArray

from aicon_baselines.evaluation.predictor import Predictor

Start = tuple[Any, dict[str, Any]]
"""The observation and the info that the `reset` of an environment returned."""


class Step(NamedTuple):
    """One step of an episode, or of a batch of B episodes; without a batch the flags are ().

    Attributes:
        observation: What the policy saw.
        before: What the environment told with it.
        action: What the policy chose.
        memory: What it remembers after that.
        next_observation: What the step led to.
        info: What the environment told with that.
        running: Whether the episode had not ended before the step, (B,).
        ended: Whether the episode ended with this very step, (B,).
    """

    observation: Any
    before: dict[str, Any]
    action: Any
    memory: Any
    next_observation: Any
    info: dict[str, Any]
    running: NDArray[np.bool_]
    ended: NDArray[np.bool_]


def run_episodes(
    policy: Predictor, env: gymnasium.Env[Any, Any] | VectorEnv[Any, Any, Any], start: Start
) -> Iterator[Step]:
    """Let a policy act until all episodes have ended, or until nobody asks for the next step.

    An ended episode stays in its batch. It begins afresh at every step, so that its memory cannot
    run away, and what is seen in it no longer counts.

    Args:
        policy: The policy; in a batch it is asked for all episodes at once.
        env: An environment, or a vector of them that leaves ended episodes alone.
        start: What its `reset` returned.
    """
    observation, info = start
    first = copy.deepcopy(observation)
    running = np.ones(env.num_envs if isinstance(env, VectorEnv) else (), np.bool_)
    starts, memory = running, None

    while running.any():
        action, memory = policy.predict(
            observation, state=memory, episode_start=starts, deterministic=True
        )
        seen, before = observation, info
        observation, _, terminated, truncated, info = env.step(action)

        ended = running & np.logical_or(terminated, truncated)
        yield Step(seen, before, action, memory, observation, info, running, ended)

        # An episode cannot begin without a reading: one that is lost is the first.
        running = running & ~ended
        starts = ~running
        observation = _completed(observation, first, starts)


def _completed(observation: Any, first: Any, rows: NDArray[np.bool_]) -> Any:
    """Return a batch of observations that in some rows (B,) has no NaN where the first had none."""
    if not rows.any():
        return observation
    if isinstance(observation, Mapping):
        return {key: _completed(observation[key], first[key], rows) for key in observation}

    in_row = rows.reshape(-1, *[1] * (observation.ndim - 1))
    lost = np.isnan(observation) & in_row
    return np.where(lost, first, observation) if lost.any() else observation
