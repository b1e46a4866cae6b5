"""Paths: enumerated as they are asked for, counted without being enumerated."""

from itertools import islice

from aicon_torch.graph import Edge, Path, PathTable


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


ROWED = {
    "g": (Edge("g", "y"), Edge("g", "x")),
    "y": (Edge("y", "w"), Edge("y", "x", 2)),
    "w": (Edge("w", "x", 2), Edge("w", "a", 3)),
    "x": (Edge("x", "a"),),
}
"""Rows that are read as a whole by the next rows, with other numbers of rows on different edges."""


def test_every_row_is_a_path_in_the_order_of_the_rows() -> None:
    table = PathTable(ROWED, ("g",), ("a",))
    assert str(table).splitlines() == [
        "g → y → w[0] → x → a",
        "g → y → w[1] → x → a",
        "g → y → w[0] → a",
        "g → y → w[1] → a",
        "g → y → w[2] → a",
        "g → y[0] → x → a",
        "g → y[1] → x → a",
        "g → x → a",
    ]
    assert len(table) == len(set(table)) == 8


def test_rows_multiply_the_count() -> None:
    """Two edges with three rows each between all layers, and a number that nobody could walk."""
    layers = 40
    edges = {"g": (Edge("g", f"x{layers}"),), "x0": (Edge("x0", "a", 1),)}
    for i in range(1, layers + 1):
        edges[f"x{i}"] = (Edge(f"x{i}", f"x{i - 1}", 3), Edge(f"x{i}", f"x{i - 1}", 3))

    table = PathTable(edges, ("g",), ("a",))
    assert table.count() == 6**layers
    assert str(next(iter(table))).endswith("x2[0] → x1[0] → x0[0] → a")


def test_the_labels_of_an_edge_name_its_rows() -> None:
    assert Edge("y", "x").labels == ("y",)
    assert Edge("y", "x", 1).labels == ("y[0]",)
    assert Edge("y", "x", 3).labels == ("y[0]", "y[1]", "y[2]")


def test_counting_follows_the_edges() -> None:
    for rungs in (1, 2, 5):
        assert len(ladder(rungs)) == len(list(ladder(rungs))) == 2 ** (rungs + 1)
    assert len(ladder(60)) == 2**61


def test_enumeration_is_lazy() -> None:
    first = list(islice(ladder(60), 3))
    assert len(set(first)) == 3
    assert all(len(path.quantities) == 61 for path in first)


def test_a_console_shows_the_first_of_many_paths() -> None:
    assert repr(ladder(2)) == str(ladder(2))
    *lines, last = repr(ladder(40)).splitlines()
    assert lines == [str(path) for path in islice(ladder(40), 100)]
    assert last == f"… {2**41} paths in all"
