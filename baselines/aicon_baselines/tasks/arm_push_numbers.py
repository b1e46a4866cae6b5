"""How the arm pushed in an episode, in numbers: errors, heights, views, limits, conflicts.

The rows of a comparison say whether an episode succeeded and when; these say how.
`arm_push_recording` takes them.
"""

import csv
import math
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple, get_type_hints

import numpy as np

from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.files import read_text, replacing


class EpisodeNumbers(NamedTuple):
    """One episode.

    Attributes:
        seed: Seed of the episode.
        success: Whether it succeeded.
        fallen: Whether the object fell off.
        time: Duration, s.
        distance: Distance at the end, mm.
        angle: Angle at the end, degrees.
        height_error: Root mean square of the tip's deviation from 20 mm after the first second, mm.
        height_low: Lowest tip after that, mm.
        height_high: Highest tip, mm.
        turns: How often per second the tip turned from rising to sinking or back, beyond its noise.
        in_view: Share of steps with the object's centre in the image.
        pose_error: Median error of the estimated position, mm.
        pose_error_95: 95th percentile, mm.
        limit_margin: Smallest distance of a joint to its limits, rad.
        self_distance: Smallest gap between capsules that can meet, m.
        collisions: Steps in which the robot touched itself or the table.
        conflicts: How often exploring began, by where and between which goals:
            ``x_ee:push/heights=2``.
        exploring: Share of steps in which any quantity explored.
        rises: Share of the other steps whose action raises, to first order, the cost of the
            gradient that leads.
    """

    seed: int
    success: bool
    fallen: bool
    time: float
    distance: float
    angle: float
    height_error: float
    height_low: float
    height_high: float
    turns: float
    in_view: float
    pose_error: float
    pose_error_95: float
    limit_margin: float
    self_distance: float
    collisions: int
    conflicts: str
    exploring: float
    rises: float

    def to_fields(self) -> list[str]:
        """The row as text."""
        return [_to_text(value) for value in self]

    @classmethod
    def from_fields(cls, fields: Iterable[str]) -> "EpisodeNumbers":
        """The row of such a text."""
        kinds = get_type_hints(cls).values()
        values = [_from_text(field, kind) for field, kind in zip(fields, kinds, strict=True)]
        return cls(*values)


def load(path: Path) -> list[EpisodeNumbers]:
    """The rows of a table, none if there is no such file.

    Raises:
        ComparisonError: If it cannot be read, or a line is not a row.
    """
    if not path.exists():
        return []

    rows = []
    for number, line in enumerate(read_text(path).splitlines()[1:], start=2):
        try:
            (fields,) = csv.reader([line])
            rows.append(EpisodeNumbers.from_fields(fields))
        except ValueError as error:
            raise ComparisonError(f"{path}, line {number} is not a row: {line!r}") from error
    return rows


def save(numbers: Iterable[EpisodeNumbers], path: Path) -> None:
    """Write a row for each episode, by seed."""
    with replacing(path) as place, place.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(EpisodeNumbers._fields)
        for row in sorted(numbers):
            writer.writerow(row.to_fields())


def in_words(numbers: Sequence[EpisodeNumbers]) -> str:
    """A few lines on several episodes."""
    # How many, and which not.
    solved = [row for row in numbers if row.success]
    longest = max((row.time for row in solved), default=math.nan)
    failures = ", ".join(_name_failure(row) for row in numbers if not row.success) or "none"

    # Between what, and how near to what.
    conflicts = conflicts_of(numbers).most_common()
    listed = ", ".join(f"{name} {count}" for name, count in conflicts) or "none"
    joint_margin = min(row.limit_margin for row in numbers)
    body_margin = 1e3 * min(row.self_distance for row in numbers)
    collided = sum(row.collisions > 0 for row in numbers)

    return (
        f"{len(solved)}/{len(numbers)} solved, median {_median(solved, 'time'):.1f} s, "
        f"longest {longest:.1f} s; failures: {failures}\n"
        f"  at the end {_median(solved, 'distance'):.1f} mm and "
        f"{_median(solved, 'angle'):.1f} deg; height within "
        f"{_median(numbers, 'height_error'):.2f} mm rms, "
        f"{_median(numbers, 'turns'):.2f} turns/s; in view {_median(numbers, 'in_view'):.0%}, "
        f"seen within {_median(numbers, 'pose_error'):.1f} mm\n"
        f"  least margin of a joint {joint_margin:.3f} rad, of the body {body_margin:.0f} mm; "
        f"episodes with a collision: {collided}\n"
        f"  exploring {_median(numbers, 'exploring'):.0%} of the time; conflicts: {listed}; "
        f"the leader's cost rises in {_median(numbers, 'rises'):.2%} of the other steps"
    )


def conflicts_of(numbers: Iterable[EpisodeNumbers]) -> Counter[str]:
    """How often exploring began in all episodes, by where and between which goals."""
    total: Counter[str] = Counter()
    for row in numbers:
        for entry in row.conflicts.split():
            name, _, count = entry.partition("=")
            total[name] += int(count)
    return total


def _median(numbers: Sequence[EpisodeNumbers], name: str) -> float:
    values = [getattr(row, name) for row in numbers]
    return float(np.median(values)) if values else math.nan


def _name_failure(row: EpisodeNumbers) -> str:
    return f"{row.seed} (fallen)" if row.fallen else str(row.seed)


def _to_text(value: Any) -> str:
    if isinstance(value, str):
        return value
    return f"{value:.4g}" if isinstance(value, float) else str(int(value))


def _from_text(text: str, kind: type) -> Any:
    return text == "1" if kind is bool else kind(text)
