"""The table of a study: a stopped one goes on, and one of another study is refused."""

from pathlib import Path
from typing import NamedTuple

import pytest

from aicon_baselines.evaluation.errors import ComparisonError
from rule_study import fill


class Cell(NamedTuple):
    rule: str
    count: int
    slope: float
    held: float


def test_what_a_table_has_is_not_measured_again(tmp_path: Path) -> None:
    asked: list[tuple[str, int]] = []

    def measure(rule: str, count: int) -> list[Cell]:
        if len(asked) == 2:
            raise KeyboardInterrupt
        asked.append((rule, count))
        return [Cell(rule, count, slope, float("nan")) for slope in (0.1, 2.0)]

    path, wanted = tmp_path / "cells.csv", [("sum", 1), ("sum", 2), ("projection", 1)]
    with pytest.raises(KeyboardInterrupt):
        fill(path, Cell, wanted, measure)
    assert asked == wanted[:2]

    asked.clear()
    cells = fill(path, Cell, wanted[1:], measure)  # those of (sum, 1) stay beside
    assert asked == wanted[2:]
    assert [cell[:3] for cell in cells] == [(*begin, s) for begin in wanted[1:] for s in (0.1, 2.0)]
    assert len(path.read_text().splitlines()) == 1 + 6


def test_a_table_of_another_study_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "cells.csv"
    path.write_text("rule,discs\nsum,2\n")
    with pytest.raises(ComparisonError, match=r"columns \['rule', 'discs'\].*--out"):
        fill(path, Cell, [("sum", 1)], lambda rule, count: [])
