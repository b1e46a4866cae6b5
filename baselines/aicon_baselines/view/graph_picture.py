"""The graph of a model as a picture, its edges as wide as the gradients along them are strong."""

import html
import re
from collections.abc import Iterator, Mapping
from itertools import pairwise

from aicon_baselines.palette import EXPLORING, OUTLINE, RESOLVED
from aicon_torch import StepTrace
from aicon_torch.graph import WorldModel

Edge = tuple[str, str]
Place = tuple[float, float]

_WIDTH, _ROW = 380.0, 50.0  # of the picture and from row to row, px
_CROWDED = 4  # nodes in a row from which on every other one is lower
_LOWER = 22.0  # px
_WIDEST = 6.0  # px
_PALE = "#d6d8dc"


class GraphPicture:
    """Goals above, actuators below, and between them what gradients pass through.

    Args:
        model: The model.
        goal_colors: The colour of each goal.
    """

    def __init__(self, model: WorldModel, goal_colors: Mapping[str, str]) -> None:
        self._goal_colors = goal_colors
        self._edges = [(name, edge.source) for name in model.edges for edge in model.edges[name]]
        self._places = _places(model, self._edges)

    def draw(self, trace: StepTrace) -> str:
        """The picture of a step, as SVG in HTML.

        An edge is as wide as the strongest gradient along it is, compared with the strongest that
        meets it; the path of each dominant gradient is dark. Where a quantity explores,
        it has another colour.
        """
        shares, led = edge_shares(trace, set(self._edges))
        height = max(y for _, y in self._places.values()) + 0.6 * _ROW
        lines = [
            f'<svg viewBox="0 0 {_WIDTH:.0f} {height:.0f}" width="100%" '
            'xmlns="http://www.w3.org/2000/svg" font-family="sans-serif" font-size="11">'
        ]
        for edge in self._edges:
            lines.append(self._line(edge, shares.get(edge, 0.0), edge in led))
        for name in self._places:
            met = trace.quantities.get(name)
            lines.append(self._node(name, met is not None and bool(met.exploring[0])))
        return "".join([*lines, "</svg>"])

    def _line(self, edge: Edge, share: float, leads: bool) -> str:
        """An edge: pale where nothing comes along, dark where the dominant one does."""
        (x1, y1), (x2, y2) = (self._places[name] for name in edge)
        color = _PALE if share == 0.0 else RESOLVED if leads else OUTLINE
        width = 1.0 + (_WIDEST - 1.0) * share**0.5
        return (
            f'<line x1="{x1:.0f}" y1="{y1:.0f}" x2="{x2:.0f}" y2="{y2:.0f}" '
            f'stroke="{color}" stroke-width="{width:.1f}" '
            f'opacity="{1.0 if leads or share == 0.0 else 0.55}"/>'
        )

    def _node(self, name: str, explores: bool) -> str:
        """A quantity or a goal, in a box."""
        x, y = self._places[name]
        width = _box_width(name)
        edge = EXPLORING if explores else self._goal_colors.get(name, OUTLINE)
        fill = "#f3e3f1" if explores else "#ffffff"
        return (
            f'<rect x="{x - width / 2:.0f}" y="{y - 10:.0f}" width="{width:.0f}" height="20" '
            f'rx="6" fill="{fill}" stroke="{edge}" stroke-width="1.6"/>'
            f'<text x="{x:.0f}" y="{y + 4:.0f}" text-anchor="middle">{html.escape(name)}</text>'
        )


def edge_shares(trace: StepTrace, edges: set[Edge]) -> tuple[dict[Edge, float], set[Edge]]:
    """How strong the gradients along each edge are, and along which edges a dominant one comes.

    Args:
        trace: What a step decided.
        edges: The edges of the graph, each from what is differentiated to what it depends on.

    Returns:
        By edge the strength of the strongest gradient along it, as a share of the strongest that
        arrives where it does; and the edges of the dominant ones.
    """
    shares: dict[Edge, float] = {}
    led: set[Edge] = set()

    for met in trace.quantities.values():
        strengths = met.magnitudes[0].tolist()
        strongest, dominant = max(strengths), int(met.dominant[0])
        if strongest == 0.0:
            continue
        for index, path in enumerate(met.paths):
            along = edges.intersection(_steps(path))
            for edge in along:
                shares[edge] = max(shares.get(edge, 0.0), strengths[index] / strongest)
            if index == dominant:
                led |= along
    return shares, led


def _steps(path: tuple[str, ...]) -> Iterator[Edge]:
    """The edges that a path may go along, such as of ("push", "x[3]+y[3]", "a")."""
    # Where gradients were merged on the way, it begins with their goals, and they came by others.
    names = path[1:] if "+" in path[0] else path
    for above, below in pairwise(names):
        for target in above.split("+"):
            for source in below.split("+"):
                yield re.sub(r"\[\d+\]", "", target), re.sub(r"\[\d+\]", "", source)


def _places(model: WorldModel, edges: list[Edge]) -> dict[str, Place]:
    """Where each node is: a row below all that depend on it, and about below them."""
    rows = _rows(model, edges)
    places: dict[str, Place] = {}
    for number in range(max(rows.values()) + 1):
        names = [name for name in rows if rows[name] == number]
        names.sort(key=lambda name: _middle_of_readers(name, edges, places))
        for index, name in enumerate(names):
            lower = _LOWER * (index % 2) if len(names) >= _CROWDED else 0.0
            half = _box_width(name) / 2.0 + 2.0
            x = min(max((index + 0.5) * _WIDTH / len(names), half), _WIDTH - half)
            places[name] = x, 16.0 + _ROW * number + lower
    return places


def _box_width(name: str) -> float:
    """Width of the box of a node, px."""
    return 12.0 + 6.3 * len(name)


def _rows(model: WorldModel, edges: list[Edge]) -> dict[str, int]:
    """The row of each node: goals at the top, the others as near to the actuators as they come."""
    rows = dict.fromkeys(model.goals, 0)
    for _ in range(len(edges)):
        for target, source in edges:
            rows[source] = max(rows.get(source, 0), rows.get(target, 0) + 1)
    return rows


def _middle_of_readers(name: str, edges: list[Edge], places: Mapping[str, Place]) -> float:
    """The mean of the places, from left to right, of what depends on a node."""
    readers = [places[target][0] for target, source in edges if source == name]
    return sum(readers) / len(readers) if readers else 0.0
