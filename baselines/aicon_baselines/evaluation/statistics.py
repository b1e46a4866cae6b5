"""What the rows of a comparison amount to, as numbers."""

from collections.abc import Callable, Hashable, Iterable, Sequence
from dataclasses import dataclass
from operator import attrgetter
from statistics import median
from typing import TypeVar

import numpy as np

from aicon_baselines.evaluation.intervals import wilson_interval
from aicon_baselines.evaluation.row import Row
from aicon_baselines.evaluation.task import Measure

_Name = TypeVar("_Name", bound=Hashable)
_Item = TypeVar("_Item")


@dataclass(frozen=True)
class Milestone:
    """The episodes that succeeded within a number of steps, with the 95 % Wilson interval."""

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
        failed_seeds: Seeds of the other episodes; a seed that failed in several repeats comes as
            often.
        collisions: Number of episodes with a collision.
        median_steps: Median steps of the successes; None without any.
        percentile_95_steps: Their 95th percentile.
        longest_steps: The most steps of a success.
        median_path_ratio: Median of path length by shortest path length of the successes; None
            without any, or if the task has no shortest path.
        median_distance: Median distance to the target at the end of the successes; None without
            any.
        measures: What else the task measures: the least of all episodes, or the median of the
            successes.
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


def summarize(
    rows: Iterable[Row], milestones: Sequence[int] = (), measures: Sequence[Measure] = ()
) -> list[Summary]:
    """Sum up the rows by condition and policy, the most successful policy first.

    Args:
        rows: The episodes of all policies.
        milestones: Numbers of steps within which successes are counted as well.
        measures: What else the rows hold.
    """
    summaries = []
    for (condition, policy), group in group_rows(rows, attrgetter("condition", "policy")).items():
        summary = _summarize_policy(policy, condition, group, milestones, measures)
        summaries.append(summary)

    def rank(summary: Summary) -> tuple[str, float, str]:
        return summary.condition, -summary.success_rate, summary.policy

    return sorted(summaries, key=rank)


def group_rows(rows: Iterable[_Item], name: Callable[[_Item], _Name]) -> dict[_Name, list[_Item]]:
    """Collect the rows, of whatever kind, that have the same name."""
    groups: dict[_Name, list[_Item]] = {}
    for row in rows:
        groups.setdefault(name(row), []).append(row)
    return groups


def reached_within(rows: Sequence[Row], steps: int) -> Milestone:
    """Count the successes of at most so many steps."""
    successes = sum(row.steps is not None and row.steps <= steps for row in rows)
    interval = wilson_interval(successes, len(rows))
    return Milestone(steps, successes, successes / len(rows), interval)


def median_of(values: Iterable[float]) -> float | None:
    """Return the median; None if there is nothing to take it of."""
    known = list(values)
    return float(median(known)) if known else None


def _summarize_policy(
    policy: str,
    condition: str,
    rows: list[Row],
    milestones: Sequence[int],
    measures: Sequence[Measure],
) -> Summary:
    # How often, and how fast.
    successes = [row for row in rows if row.success]
    failed_seeds = sorted(row.seed for row in rows if not row.success)
    steps = [row.steps for row in successes if row.steps is not None]

    # How well, and where.
    distances = [row.distance for row in successes]
    measured = {measure.key: _sum_up_measure(measure, rows) for measure in measures}
    maps = {}
    of_map = attrgetter("map")
    for name, group in group_rows(sorted(rows, key=of_map), of_map).items():
        maps[name] = _summarize_map(group)

    return Summary(
        policy=policy,
        condition=condition,
        episodes=len(rows),
        successes=len(successes),
        success_rate=len(successes) / len(rows),
        interval=wilson_interval(len(successes), len(rows)),
        milestones=[reached_within(rows, milestone) for milestone in milestones],
        failed_seeds=failed_seeds,
        collisions=sum(row.collision for row in rows),
        median_steps=median_of(steps),
        percentile_95_steps=float(np.percentile(steps, 95)) if steps else None,
        longest_steps=max(steps, default=None),
        median_path_ratio=median_of(_path_ratios(successes)),
        median_distance=median_of(distances),
        measures=measured,
        maps=maps,
    )


def _path_ratios(rows: Iterable[Row]) -> list[float]:
    """Return path length by shortest path length, where the task has a shortest path."""
    ratios = []
    for row in rows:
        if row.shortest_path_length:
            ratios.append(row.path_length / row.shortest_path_length)
    return ratios


def _sum_up_measure(measure: Measure, rows: list[Row]) -> float | None:
    """Return the least value of all episodes, or the median of the successes."""
    if measure.least:
        return min(row.measures[measure.key] for row in rows)

    values = [row.measures[measure.key] for row in rows if row.success]
    return median_of(values)


def _summarize_map(rows: list[Row]) -> MapSummary:
    successes = sum(row.success for row in rows)
    collisions = sum(row.collision for row in rows)
    return MapSummary(len(rows), successes, collisions, successes / len(rows))
