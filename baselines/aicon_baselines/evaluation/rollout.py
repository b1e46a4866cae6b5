"""Running one chunk of episodes as a batch with one policy."""

from collections.abc import Callable, Collection
from contextlib import closing
from itertools import islice
from typing import Any, NamedTuple

import numpy as np
from gymnasium.vector import VectorEnv
from numpy.typing import NDArray

from aicon_baselines.evaluation.episodes import Step, run_episodes
from aicon_baselines.evaluation.errors import ComparisonError
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

OnStep = Callable[[VectorEnv[Any, Any, Any], Step], None]
"""Called with the environment after every step, and the step."""


def rollout(
    policy: Predictor,
    task: Task,
    condition: str,
    episodes: list[Episode],
    wanted: Collection[int],
    on_ended: OnEnded = lambda outcome, indices: None,
    on_step: OnStep = lambda env, step: None,
    **options: Any,
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
        on_step: Called after every step.
        **options: Of the environment, besides those that the policy has.

    Returns:
        The outcome of each episode.

    Raises:
        ComparisonError: If the environment does not report what an outcome is made of.
    """
    options |= getattr(policy, "env_options", {})
    wanted_rows = np.isin([episode.seed for episode in episodes], list(wanted))

    with closing(task.make_env(len(episodes), condition, task.horizon, **options)) as env:
        start = env.reset(**task.reset_arguments(episodes))
        outcome = _begin(len(episodes), start[1], task.measures)

        waited_for = wanted_rows
        for step in islice(run_episodes(policy, env, start), task.horizon):
            _record(outcome, step, task.measures)
            on_step(env, step)

            waited_for = wanted_rows & step.running & ~step.ended
            if (step.ended & wanted_rows).any():
                on_ended(outcome, np.flatnonzero(step.ended & wanted_rows))
            if not waited_for.any():
                break

    # The others have come to the horizon.
    if waited_for.any():
        on_ended(outcome, np.flatnonzero(waited_for))
    return outcome


def _begin(count: int, info: dict[str, Any], measures: tuple[Measure, ...]) -> Outcome:
    """Return the outcome of `count` episodes that have just been reset."""
    _check_info(info, ("position", "distance", *(measure.key for measure in measures)))
    values = {measure.key: np.array(info[measure.key], np.float64) for measure in measures}
    return Outcome(
        steps=np.zeros(count, np.int64),
        success=np.zeros(count, np.bool_),
        collision=np.zeros(count, np.bool_),
        path_length=np.zeros(count),
        distance=np.array(info["distance"], np.float64),
        measures=values,
    )


def _record(outcome: Outcome, step: Step, measures: tuple[Measure, ...]) -> None:
    """Add one step to the episodes still running."""
    running, info = step.running, step.info
    _check_info(info, ("position", "distance", "is_success", "collision"))

    # What adds up, and what only the latest step says.
    way = np.subtract(info["position"], step.before["position"], dtype=np.float64)
    outcome.steps[running] += 1
    outcome.success[running] = info["is_success"][running]
    outcome.collision[running] |= info["collision"][running]
    outcome.path_length[running] += np.linalg.norm(way, axis=-1)[running]
    outcome.distance[running] = info["distance"][running]

    # Of some measures the least of the episode counts.
    for measure in measures:
        values, latest = outcome.measures[measure.key], info[measure.key]
        if measure.least:
            latest = np.minimum(values, latest)
        values[running] = latest[running]


def _check_info(info: dict[str, Any], keys: Collection[str]) -> None:
    """Refuse an info without what an outcome is made of."""
    missing = [key for key in keys if key not in info]
    if missing:
        raise ComparisonError(
            f"info has no {', '.join(missing)}: "
            "aicon_baselines.tasks.check_task(TASK) says what a task lacks"
        )
