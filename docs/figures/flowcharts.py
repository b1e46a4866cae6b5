"""The flowcharts of the documents as SVG, for a site that needs no network and no script.

It reads what `model.to_mermaid()` writes: nodes in four shapes, and arrows from left to right.
Nodes stand in columns, as many as there are on the longest way; in a column that it passes, an
arrow has a place of its own (K. Sugiyama, S. Tagawa and M. Toda, "Methods for visual understanding
of hierarchical system structures", 1981).
"""

import html
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from graphlib import TopologicalSorter
from itertools import pairwise
from statistics import mean

LETTER, LINE = 6.6, 15.0  # px: width of a letter, at most, and height of a line
PADDING, BETWEEN, COLUMN = 9.0, 12.0, 26.0  # px: in a box, between boxes, between columns
ROUNDS = 24  # of moving the nodes toward their neighbours

_NODE = re.compile(
    r"(?P<name>\w+)(?:\[/(?P<sensor>.*?)/\]|\[\\(?P<actuator>.*?)\\\]"
    r"|\((?P<estimate>.*?)\)|\{\{(?P<goal>.*?)\}\})?"
)


@dataclass
class Node:
    """A node, or a place that an arrow passes.

    Attributes:
        kind: "sensor", "actuator", "estimate" or "goal"; "" for a place that is passed.
        lines: Its words.
        width: Px; a place that is passed is as wide as its column.
        height: Px.
        x: Its middle, px.
        y: Its middle, px.
    """

    kind: str = ""
    lines: Sequence[str] = ()
    width: float = 0.0
    height: float = 0.0
    x: float = 0.0
    y: float = 0.0

    @classmethod
    def box(cls, kind: str, lines: Sequence[str]) -> "Node":
        """A node that is as large as its words."""
        width = LETTER * max(map(len, lines)) + 2 * PADDING
        return cls(kind, lines, width, LINE * len(lines) + PADDING)


@dataclass
class Flowchart:
    """Nodes by name, and for each arrow the names of those that it begins and ends at."""

    nodes: dict[str, Node] = field(default_factory=dict)
    arrows: list[tuple[str, str]] = field(default_factory=list)


def read(source: str) -> Flowchart:
    """Read a flowchart of Mermaid's, as far as `to_mermaid` writes it.

    Raises:
        ValueError: If it is another kind of diagram.
    """
    first, *lines = source.strip().splitlines()
    if first.strip() != "flowchart LR":
        raise ValueError(f"expected 'flowchart LR', got {first.strip()!r}")

    chart = Flowchart()
    for line in lines:
        names = [_read_node(chart, words) for words in line.split("-->")]
        chart.arrows += pairwise(names)
    return chart


def _read_node(chart: Flowchart, words: str) -> str:
    """Add the node of an expression such as "x(x<br/>P)" or "x", and return its name."""
    match = _NODE.fullmatch(words.strip())
    if match is None:
        raise ValueError(f"expected a node, such as x(x) or x, got {words.strip()!r}")

    name, *_ = match.groups()
    for kind, label in match.groupdict().items():
        if kind != "name" and label is not None:
            chart.nodes[name] = Node.box(kind, label.split("<br/>"))
    chart.nodes.setdefault(name, Node.box("estimate", [name]))
    return name


def columns_of(chart: Flowchart) -> dict[str, int]:
    """The column of each node: behind all that it reads, and a source just before its readers."""
    before: dict[str, list[str]] = {name: [] for name in chart.nodes}
    behind: dict[str, list[str]] = {name: [] for name in chart.nodes}
    for start, end in chart.arrows:
        before[end].append(start)
        behind[start].append(end)

    columns: dict[str, int] = {}
    for name in TopologicalSorter(before).static_order():
        columns[name] = max((columns[other] + 1 for other in before[name]), default=0)
    for name, readers in behind.items():
        if readers and not before[name]:
            columns[name] = min(columns[reader] for reader in readers) - 1
    return columns


def draw(source: str) -> str:
    """The flowchart as SVG; ink and paper are those of the page."""
    chart = read(source)
    columns = columns_of(chart)

    # An arrow over several columns passes a place in each.
    nodes, routes = dict(chart.nodes), []
    for number, (start, end) in enumerate(chart.arrows):
        passed = [f"{number}/{column}" for column in range(columns[start] + 1, columns[end])]
        nodes |= {name: Node() for name in passed}
        columns |= {name: int(name.partition("/")[2]) for name in passed}
        routes.append([start, *passed, end])

    table: list[list[str]] = [[] for _ in range(1 + max(columns.values()))]
    for name, column in columns.items():
        table[column].append(name)
    _place(table, nodes, routes)
    return _to_svg(nodes, routes)


def _place(
    table: list[list[str]], nodes: Mapping[str, Node], routes: Sequence[Sequence[str]]
) -> None:
    """Give every node its middle: near its neighbours, and off the others of its column."""
    neighbours: dict[str, list[str]] = {name: [] for name in nodes}
    for route in routes:
        for one, other in pairwise(route):
            neighbours[one].append(other)
            neighbours[other].append(one)

    left = 0.0
    for column in table:
        width = max(nodes[name].width for name in column)
        for row, name in enumerate(column):
            node = nodes[name]
            node.x, node.y = left + width / 2, 50.0 * row
            node.width = node.width if node.kind else width
        left += width + COLUMN

    for _ in range(ROUNDS):
        for column in (*table, *reversed(table)):
            # What nobody reads stays with its column.
            wished = {
                name: mean(nodes[other].y for other in neighbours[name] or column)
                for name in column
            }
            column.sort(key=wished.__getitem__)
            _spread(column, nodes, wished)


def _spread(column: Sequence[str], nodes: Mapping[str, Node], wished: Mapping[str, float]) -> None:
    """Move the nodes of a column to where they wish to be, and then apart."""
    lowest = -float("inf")
    for name in column:
        half = nodes[name].height / 2
        nodes[name].y = max(wished[name], lowest + half)
        lowest = nodes[name].y + half + BETWEEN

    # As much above their wishes as below them.
    excess = mean(nodes[name].y - wished[name] for name in column)
    for name in column:
        nodes[name].y -= excess


def _to_svg(nodes: Mapping[str, Node], routes: Sequence[Sequence[str]]) -> str:
    """Arrows and boxes."""
    right = max(node.x + node.width / 2 for node in nodes.values()) + 1
    top = min(node.y - node.height / 2 for node in nodes.values()) - 1
    bottom = max(node.y + node.height / 2 for node in nodes.values()) + 2

    lines = [
        f'<svg class="flowchart" viewBox="-1 {top:.0f} {right + 1:.0f} {bottom - top:.0f}" '
        f'width="{right + 1:.0f}" xmlns="http://www.w3.org/2000/svg" font-family="sans-serif" '
        'font-size="12" fill="none" stroke="currentColor">',
        '<marker id="head" viewBox="0 0 8 8" refX="8" refY="4" markerWidth="7" markerHeight="7" '
        'orient="auto"><path d="M0,0 L8,4 L0,8 z" fill="currentColor" stroke="none"/></marker>',
    ]
    lines += [_arrow([nodes[name] for name in route]) for route in routes]
    lines += [_box(node) for node in nodes.values() if node.kind]
    return "".join([*lines, "</svg>"])


def _arrow(route: Sequence[Node]) -> str:
    """A smooth line, level where it passes a column."""
    path = f"M{route[0].x + route[0].width / 2:.0f},{route[0].y:.0f}"
    for one, other in pairwise(route):
        start, end = one.x + one.width / 2, other.x - other.width / 2
        middle = (start + end) / 2
        path += f" H{start:.0f} C{middle:.0f},{one.y:.0f} {middle:.0f},{other.y:.0f}"
        path += f" {end:.0f},{other.y:.0f}"
    return f'<path d="{path}" opacity="0.6" marker-end="url(#head)"/>'


def _box(node: Node) -> str:
    """Sensors and actuators slanted, estimates round, goals with six sides."""
    left, right = node.x - node.width / 2, node.x + node.width / 2
    top, bottom = node.y - node.height / 2, node.y + node.height / 2
    cut, paper = 8.0, 'fill="var(--color-background-secondary, white)"'
    corners = {
        "sensor": [(left + cut, top), (right, top), (right - cut, bottom), (left, bottom)],
        "actuator": [(left, top), (right - cut, top), (right, bottom), (left + cut, bottom)],
        "goal": [
            *((left + cut, top), (right - cut, top), (right, node.y)),
            *((right - cut, bottom), (left + cut, bottom), (left, node.y)),
        ],
    }

    if node.kind in corners:
        points = " ".join(f"{x:.0f},{y:.0f}" for x, y in corners[node.kind])
        shape = f'<polygon points="{points}" {paper}/>'
    else:
        shape = (
            f'<rect x="{left:.0f}" y="{top:.0f}" width="{node.width:.0f}" '
            f'height="{node.height:.0f}" rx="8" {paper}/>'
        )

    first = node.y + 4 - LINE * (len(node.lines) - 1) / 2
    words = [
        f'<text x="{node.x:.0f}" y="{first + LINE * row:.0f}" text-anchor="middle" '
        f'fill="currentColor" stroke="none">{html.escape(line)}</text>'
        for row, line in enumerate(node.lines)
    ]
    return "".join([shape, *words])
