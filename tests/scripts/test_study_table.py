"""The table of a study: a stopped one goes on, and one of another study is refused."""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import pytest

from aicon_baselines.evaluation.errors import ComparisonError
from study_table import fill, fill_in_groups, read, write


class Cell(NamedTuple):
    rule: str
    count: int
    slope: float
    held: float


class Answer(NamedTuple):
    seed: int
    arrived: bool


def test_rows_are_read_as_they_were_written(tmp_path: Path) -> None:
    path = tmp_path / "answers.csv"
    assert read(path, Answer) == []

    write(path, Answer(3, True))
    write(path, Answer(4, False), Answer(5, True))
    assert read(path, Answer) == [Answer(3, True), Answer(4, False), Answer(5, True)]
    assert path.read_text().splitlines()[0] == "seed,arrived"


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


def test_what_a_table_lacks_is_measured_in_groups(tmp_path: Path) -> None:
    path = tmp_path / "answers.csv"
    write(path, Answer(3, True))
    groups: list[list[int]] = []

    def measure(group: Sequence[tuple[int]]) -> list[Answer]:
        groups.append([seed for (seed,) in group])
        return [Answer(seed, False) for (seed,) in group]

    answers = fill_in_groups(path, Answer, [(seed,) for seed in range(6)], measure, size=2)
    assert groups == [[0, 1], [2, 4], [5]]
    assert [row.seed for row in answers] == list(range(6))
    assert answers[3].arrived and len(read(path, Answer)) == 6


def test_what_is_wanted_twice_is_measured_once(tmp_path: Path) -> None:
    path, wanted = tmp_path / "answers.csv", [(1,), (2,), (1,)]
    asked: list[int] = []

    def measure(seed: int) -> list[Answer]:
        asked.append(seed)
        return [Answer(seed, True)]

    answers = fill(path, Answer, wanted, measure)
    assert asked == [1, 2]
    assert [row.seed for row in read(path, Answer)] == [1, 2]
    assert [row.seed for row in answers] == [1, 2, 1]


def test_nothing_that_is_wanted_is_no_table(tmp_path: Path) -> None:
    assert fill(tmp_path / "cells.csv", Cell, [], lambda: []) == []
    assert not (tmp_path / "cells.csv").exists()


def test_a_table_of_another_study_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "cells.csv"
    path.write_text("rule,discs\nsum,2\n")
    with pytest.raises(ComparisonError, match=r"columns \['rule', 'discs'\].*--out"):
        fill(path, Cell, [("sum", 1)], lambda rule, count: [])


def test_what_a_killed_writer_left_is_measured_again(tmp_path: Path) -> None:
    path = tmp_path / "answers.csv"
    write(path, Answer(31, True))
    with path.open("a") as file:
        file.write("32")  # of "321,True"
    assert read(path, Answer) == [Answer(31, True)]

    wanted = [(31,), (32,), (321,)]
    answers = fill(path, Answer, wanted, lambda seed: [Answer(seed, False)])
    assert [row.seed for row in answers] == [31, 32, 321]
    assert read(path, Answer) == answers


def test_rows_are_added_all_or_none(tmp_path: Path) -> None:
    path, old = tmp_path / "answers.csv", Answer(1, True)
    write(path, old)

    class Unwritable(NamedTuple):
        seed: int
        arrived: object

    class Stopped:
        def __str__(self) -> str:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write(path, Unwritable(2, True), Unwritable(3, Stopped()))
    assert read(path, Answer) == [old]
    assert [file.name for file in tmp_path.iterdir()] == [path.name]


@pytest.mark.parametrize("line", ["3", "3,True,1", "three,True"])
def test_a_line_that_is_no_row_is_named(line: str, tmp_path: Path) -> None:
    path = tmp_path / "answers.csv"
    path.write_text(f"seed,arrived\n{line}\n4,True\n")
    with pytest.raises(ComparisonError, match=r"answers.csv, line 2 is not a row"):
        read(path, Answer)


def test_a_table_has_one_writer_and_its_folder_several(tmp_path: Path) -> None:
    path = tmp_path / "answers.csv"

    def measure(seed: int) -> list[Answer]:
        fill(tmp_path / "others.csv", Answer, [(seed,)], lambda seed: [Answer(seed, True)])
        with pytest.raises(ComparisonError, match="another process is writing"):
            fill(path, Answer, [(seed,)], measure)
        return [Answer(seed, True)]

    assert fill(path, Answer, [(1,)], measure) == [Answer(1, True)]
    assert len(read(path, Answer)) == 1
