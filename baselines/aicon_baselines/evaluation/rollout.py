"""Running one chunk of episodes as a batch with one policy."""

import copy
from collections.abc import Callable, Collection, Mapping
from typing import Any, NamedTuple

import numpy as np
from gymnasium.vector import VectorEnv
from numpy.typing import NDArray

from aicon_baselines.evaluation.predictor import Predictor
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


OnEnded = Callable[[Outcome, NDArray[np.intp]], None]
"""Called with the outcome so far, and the numbers in the batch of the episodes that just ended."""


def _ignore(outcome: Outcome, indices: NDArray[np.intp]) -> None:
    """Do nothing with the episodes that ended."""


def rollout(
    policy: Predictor,
    task: Task,
    condition: str,
    episodes: list[Episode],
    wanted: Collection[int],
    on_ended: OnEnded = _ignore,
) -> Outcome:
    """Step all episodes together until those with a wanted seed have ended, at most to the horizon.

    Args:
        policy: The policy, asked for all episodes at once.
        task: The task the episodes belong to.
        condition: One of the task's conditions.
        episodes: The B episodes of the batch.
        wanted: Seeds whose outcome matters; the outcome of the others is only that of the steps
            taken meanwhile.
        on_ended: Called after a step that ended wanted episodes; what the outcome says of them is
            final.

    Returns:
        The outcome of each episode.
    """
    options = getattr(policy, "env_options", {})
    is_wanted = np.isin([episode.seed for episode in episodes], list(wanted))

    env = task.make_env(len(episodes), condition, task.horizon, **options)
    try:
        return _step_until_ended(policy, env, task, episodes, is_wanted, on_ended)
    finally:
        env.close()


def _step_until_ended(
    policy: Predictor,
    env: VectorEnv[Any, Any, Any],
    task: Task,
    episodes: list[Episode],
    wanted: NDArray[np.bool_],
    on_ended: OnEnded,
) -> Outcome:
    observation, info = env.reset(**task.reset_arguments(episodes))
    outcome = _begin(len(episodes), info, task.measures)
    position = np.array(info["position"], np.float64)

    first = copy.deepcopy(observation)

    # All episodes start, and none is known to have ended.
    running = np.ones(len(episodes), np.bool_)
    starts, state = running, None

    for _ in range(task.horizon):
        if not (running & wanted).any():
            break

        action, state = policy.predict(
            observation, state=state, episode_start=starts, deterministic=True
        )
        observation, _, terminated, truncated, info = env.step(action)
        _record(outcome, running, position, info, task.measures)
        position = np.array(info["position"], np.float64)

        ended = running & (terminated | truncated)
        running = running & ~ended

        # An ended episode stays in the batch; it begins afresh at every step, so that its memory
        # cannot run away. An episode cannot begin without a reading: one that is lost is the first.
        starts = ~running
        observation = _completed(observation, first, starts)

        if (ended & wanted).any():
            on_ended(outcome, np.flatnonzero(ended & wanted))

    # The others have come to the horizon.
    if (running & wanted).any():
        on_ended(outcome, np.flatnonzero(running & wanted))
    return outcome


def _completed(observation: Any, first: Any, rows: NDArray[np.bool_]) -> Any:
    """Return a batch of observations that in some rows (B,) has no NaN where the first had none."""
    if isinstance(observation, Mapping):
        return {key: _completed(observation[key], first[key], rows) for key in observation}

    in_row = rows.reshape(-1, *[1] * (observation.ndim - 1))
    lost = np.isnan(observation) & in_row
    return np.where(lost, first, observation) if lost.any() else observation


def _begin(count: int, info: dict[str, Any], measures: tuple[Measure, ...]) -> Outcome:
    """Return the outcome of `count` episodes that have just been reset."""
    values = {measure.key: np.array(info[measure.key], np.float64) for measure in measures}
    return Outcome(
        steps=np.zeros(count, np.int64),
        success=np.zeros(count, np.bool_),
        collision=np.zeros(count, np.bool_),
        path_length=np.zeros(count),
        distance=np.array(info["distance"], np.float64),
        measures=values,
    )


def _record(
    outcome: Outcome,
    running: NDArray[np.bool_],
    position: NDArray[np.float64],
    info: dict[str, Any],
    measures: tuple[Measure, ...],
) -> None:
    """Add one step to the episodes still running; `position` (B, 2) is that before the step."""
    # What adds up, and what only the latest step says.
    lengths = np.linalg.norm(info["position"] - position, axis=-1)
    outcome.steps[running] += 1
    outcome.success[running] = info["is_success"][running]
    outcome.collision[running] |= info["collision"][running]
    outcome.path_length[running] += lengths[running]
    outcome.distance[running] = info["distance"][running]

    # Of some measures the least of the episode counts.
    for measure in measures:
        values, latest = outcome.measures[measure.key], info[measure.key]
        if measure.least:
            latest = np.minimum(values, latest)
        values[running] = latest[running]
