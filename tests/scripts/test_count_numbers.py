"""The documents say how many numbers are set by hand; the options know it."""

from pathlib import Path

import pytest

import graph_code
from count_numbers import GRAPHS, lines_of_graph, numbers_of, numbers_of_graph


@pytest.mark.parametrize(
    ("task", "shared", "by_hand", "privileged"),
    [("nav2d", 10, 5, 0), ("pusht", 10, 5, 0), ("arm_push", 8, 34, 5), ("reach", 6, 33, 0)],
)
def test_the_documents_count_the_numbers_that_there_are(
    task: str, shared: int, by_hand: int, privileged: int
) -> None:
    counts = [sum(kind.values()) for kind in numbers_of(task)]
    assert counts == [shared, by_hand, privileged]


def test_a_number_that_serves_nothing_is_not_counted() -> None:
    escape = "resolution.exploration.escape.hold_gain"
    assert escape in numbers_of("nav2d").by_hand
    assert escape not in numbers_of("pusht").by_hand


@pytest.mark.parametrize(
    ("world", "lines", "by_hand"),
    [
        ("PointMaze", (20, 0), (4, 0)),
        ("OGBench's mazes", (20, 0), (4, 0)),
        ("A crowd", (20, 0), (4, 0)),
        ("FetchReach", (20, 0), (4, 0)),
        ("Meta-World: hand", (20, 0), (4, 0)),
        ("Meta-World: puck", (2, 167), (3, 4)),
        ("FetchPush", (3, 26), (4, 0)),
        ("SO-101: pick and place", (2, 167), (1, 4)),
    ],
)
def test_a_graph_of_other_peoples_worlds_is_no_longer_than_the_documents_say(
    world: str, lines: tuple[int, int], by_hand: tuple[int, int]
) -> None:
    counted = lines_of_graph(GRAPHS[world])
    numbers = [sum(kind.values()) for kind in numbers_of_graph(GRAPHS[world])]
    assert all(one <= most for one, most in zip(counted, lines, strict=True))
    assert all(one <= most for one, most in zip(numbers, by_hand, strict=True))


def test_the_lines_of_a_graph_are_those_of_its_code(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(graph_code, "WORLDS", tmp_path)
    (tmp_path / "parts_of_it.py").write_text(
        'def far(options):\n    """Far.\n\n    Away.\n    """\n    return options.far\n'
    )
    (tmp_path / "world_of_it.py").write_text(
        "from parts_of_it import far\n\n"
        "def build(options):\n    # It is.\n\n"
        "    walls = walls_of(options)\n    return far(options)\n\n"
        "def walls_of(options):\n    return options.maze\n\n"
        "def unused():\n    return 1\n"
    )

    functions = graph_code.functions_of("world_of_it", "build", without=["walls_of"])
    assert graph_code.lines_of(functions) == 3 + 2
    assert graph_code.options_of(functions) == {"far"}
