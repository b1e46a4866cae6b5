"""What the rows of a comparison amount to, as numbers."""

from collections.abc import Callable, Hashable, Iterable, Sequence
from dataclasses import dataclass
from statistics import median
from typing import TypeVar

import numpy as np

from aicon_baselines.evaluation.intervals import wilson_interval
from aicon_baselines.evaluation.row import Row
from aicon_baselines.evaluation.task import Measure

_Name = TypeVar("_Name", bound=Hashable)


@dataclass(frozen=True)
class Milestone:
    """The episodes that succeeded within a number of steps; the interval is the 95 % Wilson interval of their share."""

    steps: int
    successes: int
    success_rate: float
    interval: tuple[float, float]


@dataclass(frozen=True)
class MapSummary:
    """One policy on one class of maps."""

    episodes: int
    successes: int
    collisions: int
    success_rate: float


@dataclass(frozen=True)
class Summary:
    """One policy under one condition.

    Attributes:
        policy: Name of the policy.
        condition: Name of the condition.
        episodes: Number of episodes.
        successes: Number of episodes that reached the target.
        success_rate: Their share.
        interval: 95 % Wilson interval of the share.
        milestones: The same within fewer steps.
        failed_seeds: Seeds of the other episodes; a seed that failed in several repeats comes as often.
        collisions: Number of episodes with a collision.
        median_steps: Median steps of the successes; None without any.
        percentile_95_steps: Their 95th percentile.
        longest_steps: The most steps of a success.
        median_path_ratio: Median of path length by shortest path length of the successes; None without any, or if the
            task has no shortest path.
        median_distance: Median distance to the target at the end of the successes; None without any.
        measures: What else the task measures: the least of all episodes, or the median of the successes.
        maps: The same by class of maps.
    """

    policy: str
    condition: str
    episodes: int
    successes: int
    success_rate: float
    interval: tuple[float, float]
    milestones: list[Milestone]
    failed_seeds: list[int]
    collisions: int
    median_steps: float | None
    percentile_95_steps: float | None
    longest_steps: int | None
    median_path_ratio: float | None
    median_distance: float | None
    measures: dict[str, float | None]
    maps: dict[str, MapSummary]


def summarize(rows: Iterable[Row], milestones: Sequence[int] = (), measures: Sequence[Measure] = ()) -> list[Summary]:
    """Sum up the rows by condition and policy, the most successful policy first; `milestones` in steps."""
    groups = group_rows(rows, lambda row: (row.condition, row.policy))
    summaries = [
        _summary(policy, condition, group, milestones, measures) for (condition, policy), group in groups.items()
    ]
    return sorted(summaries, key=lambda summary: (summary.condition, -summary.success_rate, summary.policy))


def group_rows(rows: Iterable[Row], name: Callable[[Row], _Name]) -> dict[_Name, list[Row]]:
    """Collect the rows that have the same name."""
    groups: dict[_Name, list[Row]] = {}
    for row in rows:
        groups.setdefault(name(row), []).append(row)
    return groups


def reached_within(rows: Sequence[Row], steps: int) -> Milestone:
    """Count the successes of at most so many steps."""
    successes = sum(row.steps is not None and row.steps <= steps for row in rows)
    return Milestone(steps, successes, successes / len(rows), wilson_interval(successes, len(rows)))


def median_of(values: Iterable[float]) -> float | None:
    """Return the median; None if there is nothing to take it of."""
    known = list(values)
    return float(median(known)) if known else None


def _summary(
    policy: str, condition: str, rows: list[Row], milestones: Sequence[int], measures: Sequence[Measure]
) -> Summary:
    successes = [row for row in rows if row.success]
    steps = [row.steps for row in successes if row.steps is not None]
    return Summary(
        policy=policy,
        condition=condition,
        episodes=len(rows),
        successes=len(successes),
        success_rate=len(successes) / len(rows),
        interval=wilson_interval(len(successes), len(rows)),
        milestones=[reached_within(rows, milestone) for milestone in milestones],
        failed_seeds=sorted(row.seed for row in rows if not row.success),
        collisions=sum(row.collision for row in rows),
        median_steps=median_of(steps),
        percentile_95_steps=float(np.percentile(steps, 95)) if steps else None,
        longest_steps=max(steps, default=None),
        median_path_ratio=median_of(
            r.path_length / r.shortest_path_length for r in successes if r.shortest_path_length
        ),
        median_distance=median_of(row.distance for row in successes),
        measures={measure.key: _measured(measure, rows) for measure in measures},
        maps={name: _map_summary(group) for name, group in sorted(group_rows(rows, lambda row: row.map).items())},
    )


def _measured(measure: Measure, rows: list[Row]) -> float | None:
    if measure.least:
        return min(row.measures[measure.key] for row in rows)
    return median_of(row.measures[measure.key] for row in rows if row.success)


def _map_summary(rows: list[Row]) -> MapSummary:
    successes = sum(row.success for row in rows)
    return MapSummary(len(rows), successes, sum(row.collision for row in rows), successes / len(rows))
