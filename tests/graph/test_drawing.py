"""The graph as a picture in Mermaid."""

from _inputs import Blueprint, blueprints, built, cyclic
from hypothesis import given


def test_mermaid_shows_every_node_and_its_readers() -> None:
    drawn = cyclic().to_mermaid().splitlines()
    assert drawn[0] == "flowchart LR"

    body = "\n".join(drawn[1:])
    for name in ("z", "a", "x", "p", "P", "q", "Q", "product"):
        assert name in body

    arrows = {line.strip() for line in drawn if "-->" in line}
    filters = {"x --> p", "q --> p", "x --> q", "p --> q"}
    assert arrows == {"a --> x", *filters, "p --> product", "q --> product"}


@given(blueprints())
def test_mermaid_lists_random_graphs_completely(blueprint: Blueprint) -> None:
    graph = built(blueprint)
    drawn = graph.to_mermaid()

    for name in (*graph.quantities, *graph.goals):
        assert name in drawn
    for path in graph.paths():
        assert path.goal in drawn
