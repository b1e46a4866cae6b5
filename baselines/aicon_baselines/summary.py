"""What the rows of a comparison amount to, as numbers and as a table."""

from collections.abc import Callable, Hashable, Iterable
from dataclasses import dataclass
from statistics import median
from typing import TypeVar

from aicon_baselines.intervals import wilson_interval
from aicon_baselines.row import Row

_Name = TypeVar("_Name", bound=Hashable)


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
        collisions: Number of episodes that ended in a collision.
        median_steps: Median steps of the successes; None without any.
        median_path_ratio: Median of path length by shortest path length of the successes; None without any.
        maps: The same by class of maps.
    """

    policy: str
    condition: str
    episodes: int
    successes: int
    success_rate: float
    interval: tuple[float, float]
    collisions: int
    median_steps: float | None
    median_path_ratio: float | None
    maps: dict[str, MapSummary]


def summarize(rows: Iterable[Row]) -> list[Summary]:
    """Sum up the rows by condition and policy, the most successful policy first."""
    groups = group_rows(rows, lambda row: (row.condition, row.policy))
    summaries = [_summary(policy, condition, group) for (condition, policy), group in groups.items()]
    return sorted(summaries, key=lambda summary: (summary.condition, -summary.success_rate, summary.policy))


def group_rows(rows: Iterable[Row], name: Callable[[Row], _Name]) -> dict[_Name, list[Row]]:
    """Collect the rows that have the same name."""
    groups: dict[_Name, list[Row]] = {}
    for row in rows:
        groups.setdefault(name(row), []).append(row)
    return groups


def to_table(summaries: Iterable[Summary], time_step: float) -> str:
    """Write the summaries as a table in Markdown; `time_step` in s."""
    lines = [
        "| condition | policy | success (95 % interval) | collisions | median time | median path / shortest |",
        "|---|---|---|---|---|---|",
    ]
    for summary in summaries:
        low, high = summary.interval
        cells = (
            summary.condition,
            summary.policy,
            f"{summary.successes}/{summary.episodes} = {summary.success_rate:.1%} ({low:.1%} to {high:.1%})",
            str(summary.collisions),
            "" if summary.median_steps is None else f"{summary.median_steps * time_step:.1f} s",
            "" if summary.median_path_ratio is None else f"{summary.median_path_ratio:.2f}",
        )
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def _summary(policy: str, condition: str, rows: list[Row]) -> Summary:
    successes = [row for row in rows if row.success]
    return Summary(
        policy=policy,
        condition=condition,
        episodes=len(rows),
        successes=len(successes),
        success_rate=len(successes) / len(rows),
        interval=wilson_interval(len(successes), len(rows)),
        collisions=sum(row.collision for row in rows),
        median_steps=_median(row.steps for row in successes if row.steps is not None),
        median_path_ratio=_median(row.path_length / row.shortest_path_length for row in successes),
        maps={name: _map_summary(group) for name, group in sorted(group_rows(rows, lambda row: row.map).items())},
    )


def _map_summary(rows: list[Row]) -> MapSummary:
    successes = sum(row.success for row in rows)
    return MapSummary(len(rows), successes, sum(row.collision for row in rows), successes / len(rows))


def _median(values: Iterable[float]) -> float | None:
    known = list(values)
    return float(median(known)) if known else None
