"""A study of a policy's options: what each variant of it changes, episode by episode."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aicon_baselines.evaluation.intervals import bootstrap_interval
from aicon_baselines.evaluation.row import Row
from aicon_baselines.evaluation.statistics import (
    Milestone,
    group_rows,
    median_of,
    reached_within,
)
from aicon_baselines.evaluation.task import Task


@dataclass(frozen=True)
class Difference:
    """Mean over episodes of what a variant has more than the reference, with its 95 % interval."""

    mean: float
    interval: tuple[float, float]


@dataclass(frozen=True)
class Variant:
    """One variant, or the reference itself.

    Attributes:
        name: The variant as it was asked for.
        within: Successes within the task's last milestone; at the horizon if it has none.
        success: Successes at the horizon.
        median_steps: Median steps of the successes; None without any.
        within_difference: How much more often it succeeds within the milestone, as a share of the
            episodes.
        steps_difference: How many steps more it takes; an unsolved episode counts as the horizon.
    """

    name: str
    within: Milestone
    success: Milestone
    median_steps: float | None
    within_difference: Difference
    steps_difference: Difference


def evaluate(rows: Sequence[Row], names: Sequence[str], task: Task) -> list[Variant]:
    """Compare policies with a reference on the same episodes.

    Args:
        rows: The episodes of these policies, those of each in the same order.
        names: Names of the policies, the reference first.
        task: The task, with the horizon that the episodes had.
    """
    groups = group_rows(rows, _policy)
    reference = groups[names[0]]
    return [_compare(groups[name], reference, task) for name in names]


def mean_difference(differences: NDArray[np.float64]) -> Difference:
    """Return the mean of paired differences (n,) with its bootstrap interval."""
    return Difference(float(differences.mean()), bootstrap_interval(differences))


def _policy(row: Row) -> str:
    return row.policy


def _compare(rows: Sequence[Row], reference: Sequence[Row], task: Task) -> Variant:
    limit = task.milestones[-1] if task.milestones else task.horizon
    more_steps = _steps(rows, task.horizon) - _steps(reference, task.horizon)
    more_successes = _within(rows, limit) - _within(reference, limit)

    # Pair by pair: the same episode of the variant and of the reference.
    return Variant(
        name=rows[0].policy,
        within=reached_within(rows, limit),
        success=reached_within(rows, task.horizon),
        median_steps=median_of(row.steps for row in rows if row.steps is not None),
        within_difference=mean_difference(more_successes),
        steps_difference=mean_difference(more_steps),
    )


def _steps(rows: Sequence[Row], horizon: int) -> NDArray[np.float64]:
    """Return the steps that each episode took, (n,); an unsolved one took all."""
    steps = [horizon if row.steps is None else row.steps for row in rows]
    return np.array(steps, np.float64)


def _within(rows: Sequence[Row], limit: int) -> NDArray[np.float64]:
    """Return 1 for each episode that succeeded in so many steps and 0 for the others, (n,)."""
    succeeded = [row.steps is not None and row.steps <= limit for row in rows]
    return np.array(succeeded, np.float64)
