"""Paths: enumerated as they are asked for, counted without being enumerated."""

from itertools import islice

from aicon_torch.paths import Edge, Path, PathTable


def ladder(rungs: int) -> PathTable:
    """Two rails with crossings: the number of paths doubles with every rung."""
    edges = {"g": (Edge("g", f"l{rungs}"), Edge("g", f"r{rungs}"))}
    for i in range(rungs, 0, -1):
        for name in (f"l{i}", f"r{i}"):
            edges[name] = (Edge(name, f"l{i - 1}"), Edge(name, f"r{i - 1}"))
    for name in ("l0", "r0"):
        edges[name] = (Edge(name, "a"),)
    return PathTable(edges, ("g",), ("a",))


def test_a_path_reads_from_the_goal_to_the_actuator() -> None:
    assert str(Path("reach", ("p_tar", "x_rob"), "a")) == "reach → p_tar → x_rob → a"
    assert str(Path("rest", (), "a")) == "rest → a"


def test_paths_are_listed_goal_by_goal() -> None:
    edges = {
        "g": (Edge("g", "x"), Edge("g", "a")),
        "h": (Edge("h", "x"),),
        "x": (Edge("x", "b"), Edge("x", "a")),
    }
    table = PathTable(edges, ("g", "h"), ("a", "b"))
    assert str(table).splitlines() == ["g → x → b", "g → x → a", "g → a", "h → x → b", "h → x → a"]
    assert len(table) == 5
    assert list(table) == list(table)  # a table can be walked again


def test_counting_follows_the_edges() -> None:
    for rungs in (1, 2, 5):
        assert len(ladder(rungs)) == len(list(ladder(rungs))) == 2 ** (rungs + 1)
    assert len(ladder(60)) == 2**61


def test_enumeration_is_lazy() -> None:
    first = list(islice(ladder(60), 3))
    assert len(set(first)) == 3
    assert all(len(path.quantities) == 61 for path in first)


def test_the_length_can_be_bounded() -> None:
    edges = {
        "g": (Edge("g", "x"), Edge("g", "a")),
        "x": (Edge("x", "y"), Edge("x", "a")),
        "y": (Edge("y", "a"),),
    }
    for bound, expected in ((1, ["g → a"]), (2, ["g → x → a", "g → a"]), (3, ["g → x → y → a", "g → x → a", "g → a"])):
        table = PathTable(edges, ("g",), ("a",), max_length=bound)
        assert [str(path) for path in table] == expected
        assert len(table) == len(expected)
    assert len(PathTable(edges, ("g",), ("a",))) == 3
