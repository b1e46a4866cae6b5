"""Running one chunk of episodes as a batch with one policy."""

from collections.abc import Callable, Collection
from typing import Any, NamedTuple

import numpy as np
from gymnasium.vector import VectorEnv
from numpy.typing import NDArray

from aicon_baselines.evaluation.protocol import Predictor
from aicon_baselines.evaluation.task import Episode, Measure, Task


class Outcome(NamedTuple):
    """How the episodes of a batch of B ended.

    Attributes:
        steps: (B,) steps taken.
        success: (B,) whether the target was reached.
        collision: (B,) whether something was touched.
        path_length: (B,) length of the path taken, in the task's unit.
        distance: (B,) distance to the target at the end, in the task's unit.
        measures: (B,) each; what else the task measures.
    """

    steps: NDArray[np.int64]
    success: NDArray[np.bool_]
    collision: NDArray[np.bool_]
    path_length: NDArray[np.float64]
    distance: NDArray[np.float64]
    measures: dict[str, NDArray[np.float64]]


def rollout(
    policy: Predictor,
    task: Task,
    condition: str,
    episodes: list[Episode],
    wanted: Collection[int],
    on_finished: Callable[[int], None] = lambda count: None,
) -> Outcome:
    """Step all episodes together until those with a wanted seed have ended or the horizon is reached.

    Args:
        policy: The policy, asked for all episodes at once.
        task: The task the episodes belong to.
        condition: One of the task's conditions.
        episodes: The B episodes of the batch.
        wanted: Seeds whose outcome matters; the outcome of the others is only that of the steps taken meanwhile.
        on_finished: Called with the number of wanted episodes that a step ended.

    Returns:
        The outcome of each episode.
    """
    env = task.make_env(len(episodes), condition, task.horizon, **getattr(policy, "env_options", {}))
    try:
        return _rollout(policy, env, task, episodes, np.isin([e.seed for e in episodes], list(wanted)), on_finished)
    finally:
        env.close()


def _rollout(
    policy: Predictor,
    env: VectorEnv[Any, Any, Any],
    task: Task,
    episodes: list[Episode],
    wanted: NDArray[np.bool_],
    on_finished: Callable[[int], None],
) -> Outcome:
    count = len(episodes)
    observation, info = env.reset(**task.reset_arguments(episodes))
    outcome = Outcome(
        steps=np.zeros(count, np.int64),
        success=np.zeros(count, np.bool_),
        collision=np.zeros(count, np.bool_),
        path_length=np.zeros(count),
        distance=np.array(info["distance"], np.float64),
        measures={measure.key: np.array(info[measure.key], np.float64) for measure in task.measures},
    )
    running = np.ones(count, np.bool_)
    forget, state = running, None
    position = np.array(info["position"], np.float64)
    for _ in range(task.horizon):
        if not (running & wanted).any():
            break
        action, state = policy.predict(observation, state=state, episode_start=forget, deterministic=True)
        observation, _, terminated, truncated, info = env.step(action)
        _record(outcome, running, position, info, task.measures)
        position = np.array(info["position"], np.float64)
        ended = running & (terminated | truncated)
        running = running & ~ended
        # An ended episode stays in the batch; its memory starts afresh at every step, so it cannot run away.
        forget = ~running
        if (ended & wanted).any():
            on_finished(int((ended & wanted).sum()))
    on_finished(int((running & wanted).sum()))
    return outcome


def _record(
    outcome: Outcome,
    running: NDArray[np.bool_],
    position: NDArray[np.float64],
    info: dict[str, Any],
    measures: tuple[Measure, ...],
) -> None:
    """Add one step to the outcome of the episodes still running; `position` (B, 2) is that before the step."""
    outcome.steps[running] += 1
    outcome.success[running] = info["is_success"][running]
    outcome.collision[running] |= info["collision"][running]
    outcome.path_length[running] += np.linalg.norm(info["position"] - position, axis=-1)[running]
    outcome.distance[running] = info["distance"][running]
    for measure in measures:
        values, now = outcome.measures[measure.key], info[measure.key]
        values[running] = (np.minimum(values, now) if measure.least else now)[running]
